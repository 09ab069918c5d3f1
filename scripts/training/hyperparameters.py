"""Learning algorithms by name, and their hyperparameters, from files in the syntax of rl-zoo3."""

import inspect
from collections.abc import Mapping
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PositiveInt, TypeAdapter, ValidationError

from ...errors import InputError, install_line, shown, unknown_name
from ...files import content_of

ALGORITHMS = {
    "ppo": ("stable_baselines3", "PPO"),
    "sac": ("stable_baselines3", "SAC"),
    "tqc": ("sb3_contrib", "TQC"),
    "recurrent-ppo": ("sb3_contrib", "RecurrentPPO"),
}
DEFAULT = "default"  # entry for environments that a file does not name
NETWORKS = "policy_kwargs"  # hyperparameter with the arguments of the networks
LARGEST = 1_000_000  # bytes
_OURS = ("env", "seed", "device", "tensorboard_log", "verbose", "_init_setup_model")
_COUNTS = ("n_envs", "n_timesteps")
_Share = Annotated[float, Field(ge=0, le=1)]
_KINDS: dict[str, Any] = {  # types that are narrower than those of the algorithm
    **dict.fromkeys((*_COUNTS, "n_steps", "batch_size", "n_epochs", "buffer_size"), PositiveInt),
    **dict.fromkeys(("gamma", "gae_lambda", "tau"), _Share),
    "train_freq": PositiveInt
    | tuple[PositiveInt, Literal["step"]],  # "episode" has no fixed length
}
_CONFIG = ConfigDict(arbitrary_types_allowed=True, allow_inf_nan=False)
_LINEAR = "lin_"  # prefix of a number that decreases linearly to 0 during the training


def algorithm_class(name: str) -> Any:
    """Returns the class of an algorithm, of Stable-Baselines3 or sb3-contrib."""
    if name not in ALGORITHMS:
        raise unknown_name("algo", name, ALGORITHMS)
    module, kind = ALGORITHMS[name]
    try:
        return getattr(import_module(module), kind)
    except ImportError as error:
        raise InputError(
            f"training by {name} needs {module.replace('_', '-')}: use `make train` in a clone of "
            f"the repository, or {install_line('train')}"
        ) from error


def hyperparameters(algo: str, env: str, path: Path | None = None) -> dict[str, Any]:
    """Returns the shipped hyperparameters of an algorithm, with the values of a file in place.

    Args:
        algo: Name of the algorithm.
        env: Id of the environment, which a file may name.
        path: YAML file in the syntax of rl-zoo3: hyperparameters by the id of an environment, or
            below "default". Entries of `policy_kwargs` replace the shipped entries one by one.

    Returns:
        Arguments of the algorithm as plain data, with `policy`, `n_envs` and `n_timesteps`.
    """
    algorithm_class(algo)  # refuses an unknown name or a missing extra
    name = f"assets/hyperparameters/{algo}.yml"
    usual = _read(files("activesuit").joinpath(name).read_bytes(), name)[DEFAULT]
    usual = checked(algo, usual, name)
    if path is None:
        return usual
    parts = _read(content_of(path, "hyperparameters", LARGEST), str(path))
    given = parts.get(env, parts.get(DEFAULT))
    if not isinstance(given, dict):
        raise InputError(f"{str(path)!r} has neither {env!r} nor 'default': name one of them")
    given = checked(algo, given, str(path))
    return {**usual, **given, NETWORKS: {**usual[NETWORKS], **(given.get(NETWORKS) or {})}}


def _read(content: bytes, name: str) -> dict[str, Any]:
    import yaml

    try:
        found = yaml.safe_load(content)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{name!r} is no YAML file of hyperparameters: {reason}") from error
    if not isinstance(found, dict):
        raise InputError(f"{name!r} is {shown(found)}: give hyperparameters below 'default'")
    return found


def checked(algo: str, given: Any, where: str) -> dict[str, Any]:
    """Returns hyperparameters, converted to the types that the algorithm declares."""
    if not isinstance(given, Mapping):
        raise InputError(f"the hyperparameters in {where!r} are {shown(given)}: name each one")
    taken = inspect.signature(algorithm_class(algo)).parameters
    known = sorted({"policy", *_COUNTS, *taken} - {*_OURS})
    found = {}
    for name, value in given.items():
        if name not in known:
            raise unknown_name(f"hyperparameter of {algo} in {where!r}", name, known)
        number = _with_numbers(value)
        kind = _KINDS.get(name) or taken[name].annotation
        try:
            typed = TypeAdapter(kind, config=_CONFIG).validate_python(_schedule(number))
        except ValidationError as error:
            mistake = error.errors()[0]["msg"]
            raise InputError(
                f"{name} in {where!r} is {shown(value)}: {mistake[0].lower()}{mistake[1:]}"
            ) from error
        found[name] = number if callable(typed) else typed
    return found


def _with_numbers(value: Any) -> Any:
    """Returns a value with numbers in place of texts such as "3e-4", a text for YAML 1.1."""
    if isinstance(value, dict):
        return {name: _with_numbers(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_with_numbers(one) for one in value]
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value


def arguments(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the arguments of an algorithm; schedules are functions of the remaining share."""
    return {name: _schedule(one) for name, one in settings.items() if name not in _COUNTS}


def _schedule(value: Any) -> Any:
    if not isinstance(value, str) or not value.startswith(_LINEAR):
        return value
    try:
        begin = float(value.removeprefix(_LINEAR))
    except ValueError:
        raise InputError(f"the schedule is {value!r}: write it as lin_3e-4") from None
    return lambda left: left * begin
