"""What a command simulates: options that are given, those of training runs, and the usual ones."""

import operator
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..assets import load_suit
from ..checks import at_least
from ..envs.domain.levels import NOMINAL, with_level
from ..envs.evaluation import BOUNDS
from ..envs.making import OURS
from ..envs.model import ArmConfig
from ..envs.model.config import place_of
from ..envs.person import Person
from ..envs.policies import POLICIES, PolicySpec, needed_options, policy_spec
from ..envs.policies.network import CARD
from ..envs.policies.spec import is_saved
from ..envs.policies.trained import OBSERVATION, environment_of
from ..envs.setup import OF_ARM
from ..envs.tasks import TASKS
from ..envs.tasks.recorded import MOTION
from ..errors import InputError, shown, unknown_name
from .extensions import import_from_here
from .options import ENV, GRAVITY, LIMIT
from .own_files import is_own

COMMAND = "this command"
OUR_MODULE = "activesuit:"  # prefix of an id, for Gymnasium's worker processes
_ARM = ArmConfig()
_USUAL: dict[str, Any] = {  # what every result and every run tells
    **{"suit": _ARM.suit, "pressure": _ARM.pressure, "preconditioned": _ARM.preconditioned},
    **{"gravity": _ARM.gravity, "wearer.stature": _ARM.wearer.stature},
    **{"wearer.mass": _ARM.wearer.mass, "wearer.sex": _ARM.wearer.sex},
    **{"wearer.strength": _ARM.wearer.strength, "coupling": _ARM.coupling},
    **{"payload.mass": _ARM.payload.mass, "side": _ARM.side, "tilt": list(_ARM.tilt)},
    "allow_uncertified": _ARM.allow_uncertified,
}


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
    options: Mapping[str, Any],
    *,
    policies: Sequence[str] = (),
    level: str | None = None,
    run: Path | None = None,
    trusted: bool = False,
    usual: Mapping[str, Any] | None = None,
) -> Scene:
    """Returns what to simulate.

    An option is the one given, else that of the training runs, else the usual one. What is given of
    the arm must be as in the training runs; sensing, faults and others may differ from it, as the
    level may. The level is always among the options.

    Args:
        options: Options that are given: those of the environment by their names in Python, and
            `env`, its id, or `task`, the name of a task or the file of a motion.
        policies: Names or files of policies; the folders of training runs among them bring their
            options.
        level: Level where the options have none.
        run: Folder of a training run that goes on.
        trusted: Whether a file of a policy may name a class of a module, and a run from another
            machine the module of its environment, which are then imported.
        usual: Usual env or gravity of the command, where they differ from those of the others.

    Raises:
        InputError: An option differs from that of a training run, or two runs differ; or a run
            from another machine was trained in an environment of a module that is not ours; or
            options of the observation are given, which follows from the policies.
    """
    given = {name: value for name, value in _flat(options) if value is not None}
    given, beside = _with_env(given)
    env, level = given.get("env"), given.pop("level", level)
    found: dict[str, Any] = {}
    of = ""
    for folder in [*_runs_among(policies), *([str(run)] if run else [])]:
        theirs = run_options(folder)
        if not trusted:
            _allow_module(theirs["env"], env, folder)
        same = given if run is not None and folder == str(run) else _of_arm(given)
        _check_same(same, theirs, COMMAND, folder)
        if found:
            both = theirs if level is None else {**theirs, "level": found["level"]}
            _check_same(found, both, f"the run in {of!r}", folder)
        found, of = theirs, folder
    chosen = {"env": ENV, **(usual or {}), **found, **given}["env"]
    size = Person(sex=given.get("wearer.sex", _ARM.wearer.sex))
    own = {"wearer.stature": size.stature, "wearer.mass": size.mass}
    own |= {"gravity": _place(chosen), "level": NOMINAL}
    flat = {**_USUAL, **own, **(usual or {}), **found}
    if level not in (None, flat["level"]):  # a run has what its own level says
        flat |= {**_of_level(level, given), "level": level}
    flat |= given
    flat.pop("env", None)
    read = tuple(
        policy_spec(one, trust=True) if trusted and is_saved(one) else one for one in policies
    )
    refuse_observed(options, read)
    return Scene(env=chosen, options={**_nested(flat), **beside}, policies=read)


def refuse_observed(options: Mapping[str, Any], policies: Sequence[PolicySpec | str]) -> None:
    """Refuses options of the observation where it follows from the policies."""
    given = [name for name in OBSERVATION if options.get(name) is not None]
    if given and policies and all(one in BOUNDS or needed_options(one) for one in policies):
        raise InputError(
            f"--{given[0]} is given, and what a policy observes follows from the policy: leave it "
            "out, or name a class of your own without sensors, which takes what there is"
        )


def _with_env(given: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns options with the id of the environment, and what its task needs beside it."""
    if LIMIT in given:
        at_least(LIMIT, given[LIMIT], 1)
    if "gravity" in given:
        given["gravity"] = place_of("gravity", given["gravity"])
    if "env" in given:
        given["env"] = given["env"].removeprefix(OUR_MODULE)
    task = given.pop("task", None)
    if task is None:
        return given, {}
    if "env" in given:
        raise InputError(
            f"--task is {shown(task)}, and --env is {shown(given['env'])}: give one of them"
        )
    if task.lower().endswith(MOTION):
        return {**given, "env": ENV}, {"task": task}
    if task not in TASKS:
        raise unknown_name("task", task, [*TASKS, f"a file *{MOTION}"])
    return {**given, "env": f"{OURS}{task}-v0"}, {}


def _of_arm(given: Mapping[str, Any]) -> dict[str, Any]:
    names = {"env", *OF_ARM}
    return {name: value for name, value in given.items() if name.partition(".")[0] in names}


def _place(env: str) -> str:
    """Returns the place of the task of a shipped environment, and the usual one for others."""
    name = env.removeprefix(OURS).removesuffix("-v0")
    return TASKS[name].place if name in TASKS else GRAVITY


def _of_level(level: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what a level says of usual options, beside those that are given."""
    options = with_level({**given, "level": level})
    return {name: value for name, value in options.items() if name in _USUAL}


def run_options(folder: str) -> dict[str, Any]:
    """Returns the options with which a run was trained, by the names of their flags."""
    found = environment_of(folder)
    found = {name: value for name, value in found.items() if name not in OBSERVATION}
    env = found["env"].removeprefix(OUR_MODULE)
    return {**_USUAL, "level": NOMINAL, **dict(_flat(found)), "env": env}


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
            option = f"--{name.replace('_', '-')}"
            raise InputError(
                f"{whose} has {option} {_shown(name, options)}, and the run in {folder!r} was "
                f"trained with {_shown(name, trained)}: "
                + (f"leave {option} out" if whose == COMMAND else others)
            )


def _shown(name: str, options: Mapping[str, Any]) -> str:
    return shown(options[name]) if name in options else "the usual one"


def _same_suit(one: str, other: str) -> bool:
    return one == other or ("none" not in (one, other) and load_suit(one) == load_suit(other))


def _flat(options: Mapping[str, Any], of: str = "") -> Iterator[tuple[str, Any]]:
    """Yields options by the names of their flags, with a dot before the field of a nested one."""
    for name, value in options.items():
        if isinstance(value, Mapping) and name != "suit":
            yield from _flat(value, f"{of}{name}.")
        else:
            yield of + name, list(value) if isinstance(value, tuple) else value


def _nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options by their names in Python, from what `_flat` yields."""
    found: dict[str, Any] = {}
    for name, value in flat.items():
        *outer, last = name.split(".")
        place = found
        for part in outer:
            place = place.setdefault(part, {})
        place[last] = value
    return found
