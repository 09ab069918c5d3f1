"""What a command simulates: given options, options of training runs, and usual options."""

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
_STATED = (  # options that every result and every run states
    *("suit", "pressure", "preconditioned", "gravity", "wearer.stature", "wearer.mass"),
    *("wearer.sex", "wearer.strength", "coupling", "payload.mass", "side", "tilt"),
    "allow_uncertified",
)
_USUAL = {name: operator.attrgetter(name)(_ARM) for name in _STATED} | {"tilt": [*_ARM.tilt]}


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A task and the options of its environment.

    Attributes:
        env: Id of the environment, as MODULE:ID if another package registers the id.
        options: Options of the environment as plain values.
        policies: Given policies; a trusted file of a policy is read.
    """

    env: str
    options: dict[str, Any]
    policies: tuple[PolicySpec | str, ...] = ()

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
    """Returns the task and the options of a simulation.

    The value of an option is the given value, or else the value of the training runs, or else the
    usual value. Given options of the arm must be as in the training runs; the level, sensing,
    faults and others may differ. The level is always among the options of the result.

    Args:
        options: Given options: options of the environment by their names in Python, and `env`, the
            id of the environment, or `task`, the name of a task or the file of a motion.
        policies: Names or files of policies, or folders of training runs, whose options hold.
        level: Level, for options without a level.
        run: Folder of a training run that is resumed.
        trusted: Whether to import the module of a class that a file of a policy names, and the
            module of the environment of a run from another machine.
        usual: Usual env or gravity of the command, where they differ from other commands.
    """
    given = {name: value for name, value in _flat(options) if value is not None}
    given, beside = _with_env(given)
    env, level = given.get("env"), given.pop("level", level)
    found: dict[str, Any] = {}
    of = ""
    folders = [name for name in policies if name not in POLICIES and os.path.isdir(name)]
    for folder in [*folders, *([str(run)] if run else [])]:
        theirs = run_options(folder)
        if not trusted:
            _allow_module(theirs["env"], env, folder)
        same = given  # all options of a run that is resumed, and else those of the arm
        if run is None or folder != str(run):
            names = {"env", *OF_ARM}
            same = {name: one for name, one in given.items() if name.partition(".")[0] in names}
        _check_same(same, theirs, COMMAND, folder)
        if found:
            both = theirs if level is None else {**theirs, "level": found["level"]}
            _check_same(found, both, f"the run in {of!r}", folder)
        found, of = theirs, folder
    chosen = {"env": ENV, **(usual or {}), **found, **given}["env"]
    size = Person(sex=given.get("wearer.sex", _ARM.wearer.sex))
    own = {"wearer.stature": size.stature, "wearer.mass": size.mass}
    task = chosen.removeprefix(OURS).removesuffix("-v0")
    own |= {"gravity": TASKS[task].place if task in TASKS else GRAVITY, "level": NOMINAL}
    flat = {**_USUAL, **own, **(usual or {}), **found}
    if level not in (None, flat["level"]):  # the options of a run contain those of its own level
        of_level = with_level({**given, "level": level})
        flat |= {name: one for name, one in of_level.items() if name in _USUAL} | {"level": level}
    flat |= given
    flat.pop("env", None)
    read = tuple(
        policy_spec(one, trust=True) if trusted and is_saved(one) else one for one in policies
    )
    refuse_observed(options, read)
    return Scene(env=chosen, options={**_nested(flat), **beside}, policies=read)


def refuse_observed(options: Mapping[str, Any], policies: Sequence[PolicySpec | str]) -> None:
    """Refuses options of the observation where the policies determine the observation."""
    given = [name for name in OBSERVATION if options.get(name) is not None]
    if given and policies and all(one in BOUNDS or needed_options(one) for one in policies):
        raise InputError(
            f"--{given[0]} is given, and what a policy observes follows from the policy: leave it "
            "out, or name a class of your own without sensors, which takes what there is"
        )


def _with_env(given: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns options with the id of the environment, and the option for the file of a motion."""
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


def run_options(folder: str) -> dict[str, Any]:
    """Returns the options of the training of a run, by the names of their flags."""
    found = environment_of(folder)
    found = {name: value for name, value in found.items() if name not in OBSERVATION}
    env = found["env"].removeprefix(OUR_MODULE)
    return {**_USUAL, "level": NOMINAL, **dict(_flat(found)), "env": env}


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
            option = f"--{name.replace('_', '-')}"
            fix = "add --level" if name == "level" else "give runs of the same options"
            one, two = (
                shown(given[name]) if name in given else "the usual one"
                for given in (options, trained)
            )
            raise InputError(
                f"{whose} has {option} {one}, and the run in {folder!r} was trained with {two}: "
                + (f"leave {option} out" if whose == COMMAND else fix)
            )


def _same_suit(one: str, other: str) -> bool:
    return one == other or ("none" not in (one, other) and load_suit(one) == load_suit(other))


def _flat(options: Mapping[str, Any], of: str = "") -> Iterator[tuple[str, Any]]:
    """Yields options by the names of their flags, as `wearer.sex` for a nested option."""
    for name, value in options.items():
        if isinstance(value, Mapping) and name != "suit":
            yield from _flat(value, f"{of}{name}.")
        else:
            yield of + name, list(value) if isinstance(value, tuple) else value


def _nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options by their names in Python, which undoes `_flat`."""
    found: dict[str, Any] = {}
    for name, value in flat.items():
        *outer, last = name.split(".")
        place = found
        for part in outer:
            place = place.setdefault(part, {})
        place[last] = value
    return found
