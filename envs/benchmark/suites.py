"""The suites of the benchmark: tasks, levels, suits and policies, and the protocol of a run."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import PurePath
from typing import Any, Literal, NamedTuple

import gymnasium
import mujoco
import numpy as np

from ... import __version__
from ...assets import load_suit
from ...checks import at_least, check_seed, once
from ...errors import InputError, unknown_name
from ..domain.levels import COMPARED, LEVELS
from ..evaluation import BOUNDS, FIRST_SEED, REFERENCES
from ..evaluation.compare import check_policy
from ..evaluation.statistics import FEWEST_MOTIONS
from ..model import ArmConfig
from ..person import VoluntaryControl
from ..policies import POLICIES, PolicySpec, policy_spec
from ..policies.registry import believes, is_own
from ..policies.spec import is_saved
from ..policies.trained import shipped_policies
from ..simulation.measurements import Sensing
from ..tasks import TASKS

VERSION = 3  # wearers of version 2 could not aim, and had no cost of usual co-contraction
BELIEVED = ("mock-suit", "emu-like")
DURATIONS = {  # [s], shorter than the tasks' own durations
    **dict.fromkeys(("MinorLoops", "Handrail", "Ratchet", "Hammer", "Scoop"), 10.0),
    **{"ReachPanel": 12.0, "ObjectRelocation": 13.5, "OverheadHold": 20.0},
    **{"TransitionCurves": 21.0, "RangeOfMotion": 26.0},
}
SUITE_TASKS = {
    name: replace(task, duration=DURATIONS.get(name, task.duration)) for name, task in TASKS.items()
}
"""The tasks of the benchmark by name, some with shorter durations."""
BASELINE = "compensation"
SLOW = {"predictive": 5}  # motions of policies that take much longer than the others


class Setting(NamedTuple):
    """A task at a level with a believed suit, in which policies are compared, by names."""

    task: str
    level: str
    believed: str  # the suit that controllers believe in: the true suit, except at "shift"

    @property
    def options(self) -> dict[str, Any]:
        """Options of the environment."""
        changes = {} if self.level == "shift" else {"suit": self.believed}
        return {**changes, "level": self.level, "task": SUITE_TASKS[self.task]}

    @property
    def true_suit(self) -> str:
        """Name of the wearer's suit, which is the believed suit or, at "shift", the level's."""
        return str(LEVELS[self.level].get("suit", self.believed))


class Trial(NamedTuple):
    """One policy in one setting."""

    setting: Setting
    policy: PolicySpec  # a policy with its belief, or a reference or bound without options
    label: str  # name of the policy in tables

    @property
    def file_name(self) -> str:
        """Name of the file of the result, unique in a suite."""
        task, level, believed = self.setting
        text = json.dumps(self.policy.to_dict(), sort_keys=True, default=str)
        mark = hashlib.sha256(f"{self.label}\n{believed}\n{text}".encode()).hexdigest()[:8]
        names = (task, level, PurePath(believed).stem, self.label)
        safe = ("".join(c if c.isalnum() else "-" for c in name)[:40] for name in names)
        return f"{'.'.join(safe)}.{mark}.json"


@dataclass(frozen=True, kw_only=True)
class Suite:
    """The policies, tasks, levels and suits of a benchmark.

    At "nominal" and "randomized" controllers believe in the wearer's suit, at its usual pressure.
    At "shift" controllers believe in the same suits, but the wearer's suit is the EMU-like one at
    40 kPa: the believed suit is of another family, or has another pressure.

    Other options of the environment change the contract.
    """

    name: str
    policies: dict[str, PolicySpec]  # by their labels in tables
    tasks: tuple[str, ...] = tuple(TASKS)
    levels: tuple[str, ...] = COMPARED
    believed: tuple[str, ...] = BELIEVED  # names or files of suits that controllers believe in
    motions: int = 20  # number of motions of each policy, at least 8
    first_seed: int = FIRST_SEED  # of the motions
    coupling: Literal["rigid", "cuffs"] = "rigid"  # of the exoskeleton to the arm
    options: Mapping[str, Any] = field(default_factory=dict)  # of the environment, in all settings

    def __post_init__(self) -> None:
        for name in ("suit", "level", "coupling", "reward"):
            if name in self.options:
                raise InputError(
                    f"the suite sets the option {name} of the environment: leave {name} out, and "
                    "name believed suits, levels or another suite"
                )
        for what, names, known in (("task", self.tasks, TASKS), ("level", self.levels, LEVELS)):
            for name in names:
                if name not in known:
                    raise unknown_name(what, name, known)
            if not names:
                raise InputError(f"there are no {what}s: name at least one")
            once(f"{what}s", names)
        for suit in self.believed:
            load_suit(suit)
        at_least("motions", self.motions, FEWEST_MOTIONS)
        check_seed(self.first_seed)

    def environment(self, setting: Setting) -> dict[str, Any]:
        """Returns the options of the environment in a setting."""
        return {**setting.options, "coupling": self.coupling, **self.options}

    @property
    def has_own(self) -> bool:
        """Whether a policy is a user's code, which should not know the motions beforehand."""
        return any(map(is_own, self.policies.values()))

    def to_dict(self) -> dict[str, Any]:
        """Returns the suite as plain values, by which a folder of results knows its suite."""
        fields = ("tasks", "levels", "believed", "motions", "first_seed")
        found: dict[str, Any] = {"suite": self.name, "contract": self.contract}
        found |= {name: getattr(self, name) for name in fields}
        found["policies"] = {name: spec.to_dict() for name, spec in self.policies.items()}
        return found | self._own_options

    def check(self) -> None:
        """Makes every policy once, so that mistakes in policies and suits raise InputError."""
        for trial in replace(self, tasks=self.tasks[:1]).trials:
            if trial.label not in (*REFERENCES, *BOUNDS):
                env = f"ActiveSuit/{trial.setting.task}-v0"
                check_policy(env, trial.policy, **self.environment(trial.setting))

    @property
    def settings(self) -> list[Setting]:
        """All settings, in the order of every table."""
        return [
            Setting(task, level, suit)
            for level in self.levels
            for task in self.tasks
            for suit in self.believed
        ]

    @cached_property
    def trials(self) -> list[Trial]:
        """All trials, references and bound first, without repetition.

        Policies without belief are the same for all believed suits at "shift", and run once.
        """
        fixed = {name: PolicySpec(name) for name in (*REFERENCES, *BOUNDS[1:])}
        found: dict[str, Trial] = {}
        for setting in self.settings:
            for label, one in {**fixed, **self.policies}.items():
                trial = Trial(where(setting), one, label)
                if believes(one.name):
                    suited = PolicySpec(one.name, {"suit": setting.believed, **one.options})
                    trial = Trial(setting, suited, label)
                found[trial.file_name] = trial
        return [*found.values()]

    def motions_of(self, policy: PolicySpec) -> int:
        """Returns the number of motions of a policy."""
        return min(self.motions, SLOW.get(policy.name, self.motions))

    @cached_property
    def contract(self) -> str:
        """Hash of the conditions of comparable results: tasks, levels, suits, wearer, sensors."""
        content = {
            "version": VERSION,
            "tasks": {
                name: [type(task).__name__, asdict(task)] for name, task in SUITE_TASKS.items()
            },
            "levels": {name: LEVELS[name] for name in dict.fromkeys((*COMPARED, *self.levels))},
            "suits": {
                name: load_suit(name).model_dump(mode="json", exclude_none=True)
                for name in dict.fromkeys((*BELIEVED, *self.believed))
            },
            "arm": ArmConfig(coupling=self.coupling).to_dict(),
            "wearer": asdict(VoluntaryControl()),
            "sensing": asdict(Sensing()),
            "seed": self.first_seed,
            **self._own_options,
        }
        text = json.dumps(content, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:12]

    @property
    def _own_options(self) -> dict[str, Any]:
        return {"options": dict(self.options)} if self.options else {}

    def protocol(self, policy: PolicySpec) -> dict[str, Any]:
        """Returns the protocol of a result: version, contract, seeds, motions and packages."""
        return {
            "suite_version": VERSION,
            "contract": self.contract,
            "first_seed": self.first_seed,
            "episodes": self.motions_of(policy),
            **self._own_options,
            "activesuit": __version__,
            "mujoco": mujoco.__version__,
            "numpy": np.__version__,
            "gymnasium": gymnasium.__version__,
        }


def where(setting: Setting) -> Setting:
    """Returns the setting of results that do not depend on a believed suit."""
    return setting._replace(believed=setting.true_suit) if setting.level == "shift" else setting


# `corrected` needs cuffs; parts and additions of `compensation` have their own tables.
_OTHERS = ("oracle", "corrected", "transparent", "gravity", "complement", "inertial")
_ALL = (*(name for name in POLICIES if name not in _OTHERS), *shipped_policies())


def suite(
    name: str,
    *,
    policies: tuple[str, ...] = (),
    tasks: tuple[str, ...] = (),
    levels: tuple[str, ...] = (),
    believed: tuple[str, ...] = (),
    motions: int | None = None,
    seed: int | None = None,
    options: Mapping[str, Any] | None = None,
    trust: bool = False,
) -> Suite:
    """Returns a shipped suite, with the given arguments in place of the suite's own values.

    `seed` is that of the first motion, by default 10,000.
    """
    if name not in SUITES:
        raise unknown_name("suite", name, SUITES)
    specs = [policy_spec(given, trust=trust) for given in policies]
    names = [
        PurePath(given).stem if is_saved(given) else str(spec)
        for given, spec in zip(policies, specs, strict=True)
    ]
    once("policies", names)
    changes = {"policies": dict(zip(names, specs, strict=True)), "tasks": tasks, "levels": levels}
    changes |= {"believed": believed, "options": dict(options or {})}
    changes = {name: value for name, value in changes.items() if value}
    numbers = {"motions": motions, "first_seed": seed}
    changes |= {name: number for name, number in numbers.items() if number is not None}
    return replace(SUITES[name], **changes)


SUITES = {
    "full": Suite(name="full", policies={name: policy_spec(name) for name in _ALL}),
    "cuffs": Suite(
        name="cuffs",
        policies={
            name: policy_spec(name) for name in ("none", "transparent", "compensation", "corrected")
        },
        tasks=("ElbowFlexion", "ArmTracking", "MinorLoops", "ReachPanel"),
        coupling="cuffs",
    ),
    "quick": Suite(
        name="quick",
        policies={name: policy_spec(name) for name in ("none", "compensation")},
        tasks=("ElbowFlexion", "MinorLoops", "Ratchet"),
        believed=("emu-like",),
        motions=8,
    ),
}
"""The suites by name."""
