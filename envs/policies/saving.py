"""Makes policies of trained networks: of Stable-Baselines3, of torch, or of arrays."""

import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, shown
from ...files import replacing
from ..arm_env import ArmEnv
from ..making import OURS
from ..model.config import NO_SUIT
from ..plant import Plant
from ..tasks import TASKS
from ..vector_env import ArmVectorEnv
from .network import LAYER, LSTM_ARRAYS, Card, Network, Residual, contract_of, files_of, observed
from .trained import ARM, portable

PACKAGES = ("activesuit", "gymnasium", "mujoco", "numpy", "stable-baselines3", "torch")
_ACTIVATIONS = {"Tanh": "tanh", "ReLU": "relu"}


def save_policy(model: Any, folder: str | os.PathLike[str], env: Any) -> None:
    """Saves a trained network as a policy, for every command that takes a policy.

    Args:
        model: PPO, A2C or SAC of Stable-Baselines3, TQC or RecurrentPPO of sb3-contrib; or, of any
            other learner, the network of the mean action: a `torch.nn.Sequential` of Linear layers
            with Tanh or ReLU between them, whose actions are clipped to -1 and 1 or pass a last
            Tanh, or a `Network` of arrays.
        folder: New folder of the policy, or an existing one, whose files are replaced.
        env: Environment of the training, single or vector, wrapped or not.
    """
    folder, arms = Path(folder), _arms_of(env)
    network, plant = network_of(model), Plant.of(arms.episodes)
    task, config = arms.episodes.task, plant.config.to_dict()
    if not isinstance(config["suit"], str):
        raise InputError("the environment's suit has no file: save the suit, and name the file")
    name = f"{OURS}{task.name}-v0"
    if TASKS.get(task.name) is not task:
        raise InputError(
            f"the environment's task {task.name!r} is not a shipped one: train it by `activesuit "
            "train --env MODULE:ID`, whose folder is a policy"
        )
    residual = _residual_of(env)
    size = int(np.prod(plant.observation_space.shape)) + (plant.motors if residual else 0)
    if (network.inputs, network.outputs) != (size, plant.motors):
        raise InputError(
            f"the network has {network.inputs} inputs and {network.outputs} outputs, and the "
            f"environment {size} observed numbers and {plant.motors} motors: give the environment "
            "of the training, and the network of the mean action alone"
        )
    done = {"done": int(model.num_timesteps)} if hasattr(model, "num_timesteps") else {}
    observer, belief = arms.episodes.observer, arms.episodes.setup.belief
    seen = {"sensors": list(observer.sensors), "normalize": observer.normalized}
    seen |= {"history": observer.history}
    if belief is not None:
        suit = belief.to_dict()["suit"]
        if not isinstance(suit, str):
            raise InputError("the believed suit has no file: save the suit, and name the file")
        suit = suit if suit == NO_SUIT else portable(suit)
        seen["belief"] = {**belief.to_dict(), "suit": suit}
    environment = {"env": name, **{field: config[field] for field in ARM}, **seen}
    if plant.config.payload.inertia is None:  # as in cards of `activesuit train`
        environment["payload"] = {"mass": plant.config.payload.mass}
    card = card_of(
        plant,
        environment=environment,
        training={"algo": type(model).__name__, **done},
        residual=residual,
    )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot make the folder {str(folder)!r} ({error.strerror}): choose another one"
        ) from error
    for file, content in files_of(card, network).items():
        with replacing(folder / file) as scratch:
            scratch.write_bytes(content)


def card_of(
    plant: Plant,
    environment: dict[str, Any],
    training: dict[str, Any],
    residual: Residual | None = None,
) -> Card:
    """Returns the card of a policy of some arms."""
    observation, versions = observed(plant), {}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            versions[name] = version(name)
    return Card(
        observation=observation,
        contract=contract_of(observation),
        environment=environment,
        residual=residual,
        training=training,
        versions=versions,
    )


def network_of(model: Any) -> Network:
    """Returns the network that makes the mean action of a trained model; see `save_policy`."""
    if isinstance(model, Network):
        return model
    from torch import nn

    if isinstance(model, nn.Sequential):
        parts = list(model)
        squashed = bool(parts) and len(parts) % 2 == 0 and isinstance(parts[-1], nn.Tanh)
        return _layered(model, parts[:-1] if squashed else parts, {}, squashed)
    policy: Any = getattr(model, "policy", None)
    weights: dict[str, NDArray[np.float32]] = {}
    if hasattr(policy, "actor") and hasattr(policy.actor, "latent_pi"):  # SAC, TQC
        between, last, squashed = policy.actor.latent_pi, policy.actor.mu, True
        features = policy.actor.features_extractor
        if policy.actor.use_sde and policy.actor.clip_mean:
            raise _foreign(model, "use_sde clips its mean actions: give policy_kwargs clip_mean 0")
    elif hasattr(policy, "action_net"):  # PPO, A2C, RecurrentPPO
        between, last = policy.mlp_extractor.policy_net, policy.action_net
        squashed = bool(policy.squash_output)
        features = policy.features_extractor
    else:
        raise _foreign(model, "it is no PPO or SAC, no torch.nn.Sequential and no Network")
    if type(features).__name__ != "FlattenExtractor":
        raise _foreign(model, "it extracts features before its layers")
    normalizing = model.get_vec_normalize_env()
    if normalizing is not None and normalizing.norm_obs:
        raise _foreign(model, "VecNormalize scales its observations: use normalize=True instead")
    if hasattr(policy, "lstm_actor"):
        if policy.lstm_actor.num_layers != 1:
            raise _foreign(model, f"it has {policy.lstm_actor.num_layers} layers of LSTM: use one")
        part = {name: _numbers(one) for name, one in policy.lstm_actor.named_parameters()}
        bias = part["bias_ih_l0"] + part["bias_hh_l0"]
        weights = dict(
            zip(LSTM_ARRAYS, (part["weight_ih_l0"], part["weight_hh_l0"], bias), strict=True)
        )
    return _layered(model, [*between, last], weights, squashed)


def _layered(
    model: Any, parts: Sequence[Any], weights: dict[str, NDArray[np.float32]], squashed: bool
) -> Network:
    """Returns the network of modules of torch, behind the weights of an LSTM if there is one."""
    from torch import nn

    layers, between = parts[::2], {type(one).__name__ for one in parts[1::2]}
    if (
        len(parts) % 2 == 0
        or any(type(one) is not nn.Linear or one.bias is None for one in layers)
        or len(between) > 1
        or not between <= _ACTIVATIONS.keys()
    ):
        kinds = ", ".join(type(one).__name__ for one in parts) or "none"
        raise _foreign(
            model, f"its parts are {kinds}: use Linear layers with bias, and Tanh or ReLU between"
        )
    weights |= layers_of(layers)
    return Network(weights, _ACTIVATIONS[between.pop()] if between else "tanh", squashed)


def layers_of(layers: Iterable[Any]) -> dict[str, NDArray[np.float32]]:
    """Returns the weights of those layers that are Linear of torch, by their names in a network."""
    from torch import nn

    found = {}
    for i, layer in enumerate(one for one in layers if isinstance(one, nn.Linear)):
        found[f"{LAYER}.{i}.weight"] = _numbers(layer.weight)
        found[f"{LAYER}.{i}.bias"] = _numbers(layer.bias)
    return found


def _numbers(values: Any) -> NDArray[np.float32]:
    return values.detach().cpu().numpy().astype(np.float32)


def _foreign(model: Any, reason: str) -> InputError:
    return InputError(f"no policy can be made of this {type(model).__name__}: {reason}")


def _arms_of(env: Any) -> ArmEnv | ArmVectorEnv:
    """Returns the environment inside its wrappers, of Gymnasium and of Stable-Baselines3."""
    found = env
    while hasattr(found, "venv"):  # wrappers of Stable-Baselines3
        found = found.venv
    found = getattr(found, "arms", found)
    if hasattr(found, "envs"):  # DummyVecEnv
        found = found.envs[0]
    found = getattr(found, "unwrapped", found)
    if not isinstance(found, ArmEnv | ArmVectorEnv):
        raise InputError(f"env is {shown(env)}: give the ActiveSuit environment of the training")
    return found


def _residual_of(env: Any) -> Residual | None:
    """Returns the policy that is corrected in an environment of Stable-Baselines3."""
    while env is not None:
        found = vars(env).get("residual")
        if isinstance(found, Residual):
            return found
        env = vars(env).get("venv")
    return None
