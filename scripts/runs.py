"""What a command simulates: options that are given, those of training runs, and the usual ones."""

import operator
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..assets import load_suit
from ..envs.evaluation import BOUNDS
from ..envs.levels import NOMINAL, with_level
from ..envs.making import OURS
from ..envs.policies import POLICIES, PolicySpec, needed_options, policy_spec
from ..envs.policies.build import is_saved
from ..envs.policies.network import CARD
from ..envs.policies.trained import OBSERVATION, environment_of
from ..envs.setup import OF_ARM
from ..envs.tasks import TASKS
from ..envs.tasks.recorded import MOTION
from ..errors import InputError, shown, unknown_name
from .arm_options import USUAL_OPTIONS, ArmOptions, flat_options, nested_options, usual_size
from .extensions import import_from_here
from .options import ENV, GRAVITY
from .own_files import is_own

COMMAND = "this command"
FLAGS = ("env", "level", *USUAL_OPTIONS)
OUR_MODULE = "activesuit:"  # prefix of an id, for Gymnasium's worker processes


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A task and the options of its environment.

    Attributes:
        env: Id of the environment, with the module that registers it if it is not ours.
        options: Options of the environment as plain values.
        policies: Policies that were given; those in trusted files are read.
    """

    env: str
    options: dict[str, Any]
    policies: tuple[PolicySpec | str, ...] = ()

    @property
    def arm(self) -> dict[str, Any]:
        """Those of the options that are fields of `ArmConfig`."""
        return {name: value for name, value in self.options.items() if name in OF_ARM}

    @property
    def place(self) -> str:
        """Title of a table: task, place, suit and level."""
        task = self.options.get("task", self.env)
        place, suit, level = (self.options[name] for name in ("gravity", "suit", "level"))
        return f"{task}, {place}, {suit}, level {level}"


def scene(
    arm: ArmOptions,
    *,
    env: str | None = None,
    task: str | None = None,
    level: str | None = None,
    suit: str | None = None,
    gravity: str | None = None,
    policies: Sequence[str] = (),
    run: Path | None = None,
    trusted: bool = False,
    usual: Mapping[str, Any] | None = None,
) -> Scene:
    """Returns what to simulate.

    An option is the one given, else that of the training runs, else the usual one. What is given of
    the arm must be as in the training runs; sensing, faults and others may differ from it, as the
    level may. The level is always among the options.

    Args:
        arm: Options of wearer, coupling and load, and those of `--set`.
        env: Id of the environment; None if it is not given.
        task: Name of a task, or file of a motion; None if it is not given.
        level: Name of a level; None if it is not given.
        suit: Name or file of the suit; None if it is not given.
        gravity: Name of the place; None if it is not given.
        policies: Names or files of policies; the folders of training runs among them bring their
            options.
        run: Folder of a training run that goes on.
        trusted: Whether a file of a policy may name a class of a module, and a run from another
            machine the module of its environment, which are then imported.
        usual: Usual env, suit or gravity of the command, where they differ from those of the
            others.

    Raises:
        InputError: An option differs from that of a training run, or two runs differ; or a run
            from another machine was trained in an environment of a module that is not ours; or
            options of the observation are given, which follows from the policies.
    """
    env, beside = _task(env and env.removeprefix(OUR_MODULE), task)
    given = arm.given(env=env, level=level, suit=suit, gravity=gravity)
    level = given.pop("level", None)
    found: dict[str, Any] = {}
    of = ""
    for folder in [*_runs_among(policies), *([str(run)] if run else [])]:
        options = run_options(folder)
        if not trusted:
            _allow_module(options["env"], env, folder)
        same = given if run is not None and folder == str(run) else _of_arm(given)
        _check_same(same, options, COMMAND, folder)
        if found:
            theirs = options if level is None else {**options, "level": found["level"]}
            _check_same(found, theirs, f"the run in {of!r}", folder)
        found, of = options, folder
    chosen = {"env": ENV, **(usual or {}), **found, **given}["env"]
    own = {"gravity": _place(chosen), "level": NOMINAL, **usual_size(given)}
    flat = {**USUAL_OPTIONS, **own, **(usual or {}), **found}
    if level not in (None, flat["level"]):  # a run has what its own level says
        flat |= {**_of_level(level, given), "level": level}
    flat |= given
    flat |= {name: {**found[name], **given[name]} for name in given if _fields(name, given, found)}
    flat.pop("env", None)
    read = tuple(
        policy_spec(one, trust=True) if trusted and is_saved(one) else one for one in policies
    )
    refuse_observed(given, read)
    return Scene(env=chosen, options={**nested_options(flat), **beside}, policies=read)


def refuse_observed(options: Mapping[str, Any], policies: Sequence[PolicySpec | str]) -> None:
    """Refuses options of the observation where it follows from the policies."""
    given = [name for name in OBSERVATION if name in options]
    if given and policies and all(one in BOUNDS or needed_options(one) for one in policies):
        raise InputError(
            f"--set gives {given[0]}, and what a policy observes follows from the policy: leave it "
            "out, or name a class of your own without sensors, which takes what there is"
        )


def _fields(name: str, *both: Mapping[str, Any]) -> bool:
    return all(isinstance(one.get(name), dict) for one in both)


def _of_arm(given: Mapping[str, Any]) -> dict[str, Any]:
    names = {"env", *USUAL_OPTIONS, *OF_ARM}
    return {name: value for name, value in given.items() if name.partition(".")[0] in names}


def _task(env: str | None, task: str | None) -> tuple[str | None, dict[str, Any]]:
    """Returns the id of the environment of a task, and options that the task needs beside it."""
    if task is None:
        return env, {}
    if env is not None:
        raise InputError(f"--task is {shown(task)}, and --env is {shown(env)}: give one of them")
    if task.lower().endswith(MOTION):
        return ENV, {"task": task}
    if task not in TASKS:
        raise unknown_name("task", task, [*TASKS, f"a file *{MOTION}"])
    return f"{OURS}{task}-v0", {}


def _place(env: str) -> str:
    """Returns the place of the task of a shipped environment, and the usual one for others."""
    name = env.removeprefix(OURS).removesuffix("-v0")
    return TASKS[name].place if name in TASKS else GRAVITY


def _of_level(level: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what a level says of options of the command line, beside those that are given."""
    options = with_level({**given, "level": level})
    return {name: value for name, value in options.items() if name in USUAL_OPTIONS}


def run_options(folder: str) -> dict[str, Any]:
    """Returns the options of the command line with which a run was trained."""
    found = environment_of(folder)
    found = {name: value for name, value in found.items() if name not in OBSERVATION}
    env = found["env"].removeprefix(OUR_MODULE)
    return {**USUAL_OPTIONS, "level": NOMINAL, **flat_options(found), "env": env}


def _runs_among(policies: Sequence[str]) -> list[str]:
    return [name for name in policies if name not in POLICIES and os.path.isdir(name)]


def _allow_module(trained_on: str, given: str | None, folder: str) -> None:
    if ":" not in trained_on or given == trained_on:
        return
    if not is_own((Path(folder) / CARD).read_bytes()):
        raise InputError(
            f"the run in {folder!r} needs {shown(trained_on)}, and its {CARD} is not of this "
            f"machine: add --env {trained_on} if that module may be imported"
        )
    import_from_here()


def _check_same(
    options: Mapping[str, Any], trained: Mapping[str, Any], whose: str, folder: str
) -> None:
    for name in options if whose == COMMAND else {**options, **trained}:
        value: Any = options.get(name)
        other: Any = trained.get(name)
        same = _same_suit if name == "suit" else operator.eq
        if not same(value, other):
            others = "add --level" if name == "level" else "give runs of the same options"
            option = f"--{name.replace('_', '-')}" if name in FLAGS else f"--set {name}"
            raise InputError(
                f"{whose} has {option} {_shown(name, options)}, and the run in {folder!r} was "
                f"trained with {_shown(name, trained)}: "
                + (f"leave {option} out" if whose == COMMAND else others)
            )


def _shown(name: str, options: Mapping[str, Any]) -> str:
    return shown(options[name]) if name in options else "the usual one"


def _same_suit(one: str, other: str) -> bool:
    return one == other or ("none" not in (one, other) and load_suit(one) == load_suit(other))
