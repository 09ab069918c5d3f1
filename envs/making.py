"""Makes environments by their ids, shipped ones and those of a user."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from importlib import import_module
from typing import Any

import gymnasium
from gymnasium.envs.registration import load_env_creator
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker, TimeLimit

from ..errors import InputError, shown, unknown_name
from .arm_env import ArmEnv
from .tasks import TASKS
from .vector_env import ArmVectorEnv

OURS = "ActiveSuit/"  # prefix of the ids of shipped environments
ROWS_ONLY = tuple(ArmVectorEnv.__init__.__kwdefaults__ or ())  # options of rows, not of tasks


def make_env(env_id: str, **options: Any) -> tuple[gymnasium.Env, ArmEnv]:
    """Makes an ActiveSuit environment; returns the environment, and the `ArmEnv` in its wrappers.

    Args:
        env_id: Id of a registered environment whose class is an `ArmEnv`; as "module:id", the
            module is imported first.
        **options: Options of the environment (`suit`, `gravity`, ...).
    """
    name = _imported(env_id)
    with nullcontext() if name.startswith(OURS) else _own_code(env_id):
        env = gymnasium.make(name, **options)
    if not isinstance(env.unwrapped, ArmEnv):
        env.close()
        raise _no_arm(env_id)
    return env, env.unwrapped


def _imported(env_id: str) -> str:
    """Imports the module of an environment; returns the name of the registered environment."""
    if not isinstance(env_id, str):
        raise InputError(f"env_id is {shown(env_id)}: give the id of an environment")
    module, _, name = env_id.rpartition(":")
    with _own_code(env_id):
        if module:
            import_module(module)
        made_by = gymnasium.registry[name].entry_point if name in gymnasium.registry else None
        made_by = load_env_creator(made_by) if isinstance(made_by, str) else made_by
    if name not in gymnasium.registry:
        ours = [f"{OURS}{task}-v0" for task in TASKS]
        raise unknown_name("environment", env_id, ours)
    if made_by is None or (isinstance(made_by, type) and not issubclass(made_by, ArmEnv)):
        raise _no_arm(env_id)
    return name


@contextmanager
def _own_code(env_id: str) -> Iterator[None]:
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # user code may raise anything
        raise InputError(
            f"the environment {env_id!r} cannot be made ({type(error).__name__}: {error}): repair "
            "it, or name a module that is installed or in the working folder"
        ) from error


def _no_arm(env_id: str) -> InputError:
    return InputError(
        f"the environment {env_id!r} is no arm of ActiveSuit: register one that makes an "
        "activesuit.envs.ArmEnv"
    )


def make_arms(env_id: str, rows: int, **options: Any) -> ArmVectorEnv:
    """Makes a vector environment of the task of a registered id.

    Args:
        env_id: Id of a registered environment whose class is an `ArmEnv`; see `make_env`.
        rows: Number of rows.
        **options: Options of the environment, and of `ArmVectorEnv`.
    """
    of_rows = {one: options.pop(one) for one in ROWS_ONLY if one in options}
    made, arm = make_env(env_id, **options)  # a function or a wrapper may decide what is made
    made.close()
    limit, layer = None, made
    while isinstance(layer, gymnasium.Wrapper):
        if isinstance(layer, TimeLimit):
            limit = layer._max_episode_steps
        elif not isinstance(layer, OrderEnforcing | PassiveEnvChecker):
            raise InputError(
                f"the environment {env_id!r} has the wrapper {type(layer).__name__}, which rows of "
                "arms cannot have: register it without, and change the task or the options instead"
            )
        layer = layer.env
    kind = type(arm)
    parents = kind.__mro__[: kind.__mro__.index(ArmEnv)]
    own = {name for one in parents for name in vars(one) if not name.startswith("_")}
    overridden = sorted(own & {*dir(ArmEnv), *vars(arm)} - {"metadata"})
    if overridden:
        raise InputError(
            f"{env_id!r} overrides {', '.join(overridden)} of ArmEnv, which the vector environment "
            "would ignore: change its task or options instead"
        )
    return arm.rows(rows, **{"max_episode_steps": limit, **of_rows})
