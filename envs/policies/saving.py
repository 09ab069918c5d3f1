"""Makes policies of what Stable-Baselines3 trained (needs the extra `train`)."""

import os
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, shown
from ...files import replacing
from ..arm_env import ArmEnv
from ..making import OURS
from ..plant import Plant
from ..tasks import TASKS
from ..vector_env import ArmVectorEnv
from .network import (
    LAYER,
    LSTM,
    Card,
    Network,
    Residual,
    contract_of,
    files_of,
    observed,
)
from .trained import ARM

PACKAGES = ("activesuit", "gymnasium", "mujoco", "numpy", "stable-baselines3", "torch")
_ACTIVATIONS = {"Tanh": "tanh", "ReLU": "relu"}


def save_policy(model: Any, folder: str | os.PathLike[str], env: Any) -> None:
    """Makes a policy of a model of Stable-Baselines3, for every command that takes a policy.

    Args:
        model: PPO, A2C, SAC, or of sb3-contrib TQC or RecurrentPPO, on vectors of numbers.
        folder: Folder of the policy, which is made; one that is there gets new files.
        env: Environment that the model was trained in, single or vector, wrapped or not.

    Raises:
        InputError: The network or the environment is none that a policy can have, or the folder
            cannot be written.
    """
    folder, arms = Path(folder), _arms_of(env)
    network, plant = network_of(model), Plant.of(arms.episodes)
    task, config = arms.episodes.task, plant.config.to_dict()
    if not isinstance(config["suit"], str):
        raise InputError("the environment has a suit that is no file: save it, and name its file")
    name = f"{OURS}{task.name}-v0"
    if TASKS.get(task.name) is not task:
        raise InputError(
            f"the environment's task {task.name!r} is not a shipped one: train it by `activesuit "
            "train --env MODULE:ID`, whose folder is a policy"
        )
    observer, belief = arms.episodes.observer, arms.episodes.setup.belief
    seen = {"sensors": list(observer.sensors), "normalize": observer.normalized}
    seen |= {"history": observer.history} | ({"belief": belief.to_dict()} if belief else {})
    card = card_of(
        plant,
        environment={"env": name, **{field: config[field] for field in ARM}, **seen},
        training={"algo": type(model).__name__, "done": int(model.num_timesteps)},
        residual=_residual_of(env),
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
    observation = observed(plant)
    return Card(
        observation=observation,
        contract=contract_of(observation),
        environment=environment,
        residual=residual,
        training=training,
        versions={name: version(name) for name in PACKAGES},
    )


def network_of(model: Any) -> Network:
    """Returns the network that makes the mean action of a model of Stable-Baselines3.

    Raises:
        InputError: It has parts that a policy cannot have.
    """
    from torch import nn

    policy, weights = model.policy, {}
    if hasattr(policy, "actor") and hasattr(policy.actor, "latent_pi"):  # SAC, TQC
        between, last, squashed = policy.actor.latent_pi, policy.actor.mu, True
        features = policy.actor.features_extractor
    elif hasattr(policy, "action_net"):  # PPO, A2C, RecurrentPPO
        between, last, squashed = policy.mlp_extractor.policy_net, policy.action_net, False
        features = policy.features_extractor
    else:
        raise _foreign(model, "its policy is neither PPO's nor SAC's")
    if type(features).__name__ != "FlattenExtractor":
        raise _foreign(model, "it extracts features before its layers")
    normalizing = model.get_vec_normalize_env()
    if normalizing is not None and normalizing.norm_obs:
        raise _foreign(model, "VecNormalize scales its observations: use normalize=True instead")
    if hasattr(policy, "lstm_actor"):
        if policy.lstm_actor.num_layers != 1:
            raise _foreign(model, f"it has {policy.lstm_actor.num_layers} layers of LSTM: use one")
        part = {name: _numbers(one) for name, one in policy.lstm_actor.named_parameters()}
        weights[f"{LSTM}.input"], weights[f"{LSTM}.hidden"] = (
            part["weight_ih_l0"],
            part["weight_hh_l0"],
        )
        weights[f"{LSTM}.bias"] = part["bias_ih_l0"] + part["bias_hh_l0"]
    kinds = {type(one).__name__ for one in between if not isinstance(one, nn.Linear)}
    if not isinstance(last, nn.Linear) or len(kinds) > 1 or not kinds <= _ACTIVATIONS.keys():
        raise _foreign(
            model, f"between its layers are {', '.join(sorted(kinds))}: use Tanh or ReLU"
        )
    weights |= layers_of((*between, last))
    return Network(weights, _ACTIVATIONS[kinds.pop()] if kinds else "tanh", squashed)


def layers_of(layers: Iterable[Any]) -> dict[str, NDArray[np.float32]]:
    """Returns the weights of the linear layers of torch among some, by their names in a network."""
    from torch import nn

    linear, found = [one for one in layers if isinstance(one, nn.Linear)], {}
    for i, layer in enumerate(linear):
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
    if isinstance(found, gymnasium.Env | gymnasium.vector.VectorEnv):
        found = found.unwrapped
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
