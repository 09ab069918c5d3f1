"""The setup of an environment: all its options but the number of rows, checked and complete.

    >>> from activesuit.envs.tasks import TASKS
    >>> setup = Setup.of(TASKS["Scoop"], {"suit": "emu-like", "control": {"noise": 1.0}})
    >>> setup.sensors, setup.control_dt, setup.control.noise
    (('encoders',), 0.01, 1.0)
    >>> setup.arm.suit, setup.arm.gravity, setup.fatigue
    ('emu-like', 'moon', False)

A setup is plain data that never changes, and that single and vector environments share. All checks
of options are made here and nowhere else. `DEFAULTS` has the values of options that are not given;
`Task` decides place and fatigue.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from ..checks import flag, within
from ..errors import InputError, refuse_old_names, shown, unknown_name
from .domain.levels import with_level
from .domain.randomization import Randomization
from .interface.observation import DEFAULT_SENSORS, checked_sensors
from .interface.own_code import OwnReward
from .model import ArmConfig
from .model.config import nested
from .person import VoluntaryControl
from .simulation.faults import Faults
from .simulation.measurements import Sensing
from .simulation.state import PREVIEW
from .tasks import Task

ROUNDING = 1e-9  # s


@dataclass(frozen=True, kw_only=True)
class Setup:
    """The options of an environment, which `ArmEnv` and `ArmVectorEnv` take as keyword arguments.

    `Setup.of` makes a setup from keyword arguments: the fields below by their names, those of
    `arm` by theirs (suit, gravity, wearer, ...), and `level`. Nested fields also take a dict of the
    values that differ from the default.

    Attributes:
        arm: Wearer, suit, exoskeleton, load and place.
        sensors: Names of the sensor suites that make up the observation.
        normalize: Whether observations are divided by constants, to the size of 1.
        history: Number of control periods whose observations make up one observation, the newest
            first; the first observation of an episode also stands for the periods before it.
        control_dt: Time between actions [s]; it is a multiple of the physics step and divides
            0.02 s.
        control: The wearer's control of the arm, whose default delay is the multiple of
            `control_dt` that is nearest to 0.05 s.
        fatigue: Whether the wearer's muscles tire, from a rested start in every episode; by default
            the task decides.
        randomize: What differs from episode to episode beside the motion.
        sensing: Noise, delay and bandwidth of sensors.
        faults: Faults of sensors and motors.
        belief: Arm that the suite "belief" believes in, given by the fields of `arm` in which the
            believed arm differs from the simulated arm, such as {"suit": "elbow.json"}. The belief
            never follows the draws of `randomize`. None without that suite.
        reward: Function that replaces the shipped reward, or the place of this function as
            "package.module:function"; see `OwnReward`. Scores of evaluations do not change.
    """

    arm: ArmConfig
    sensors: tuple[str, ...]
    normalize: bool
    history: int
    control_dt: float
    control: VoluntaryControl
    fatigue: bool
    randomize: Randomization
    sensing: Sensing
    faults: Faults
    belief: ArmConfig | None
    reward: OwnReward | None

    @classmethod
    def of(cls, task: Task, options: Mapping[str, Any]) -> "Setup":
        """Returns the setup of an environment, from options by their names.

        The options of a `level` apply where none is given; the task decides place and fatigue where
        no option does.
        """
        refuse_old_names(options, {"taught": "learned_torque", "episodes": "motions"})
        for name in options:
            if name not in OPTIONS:
                raise unknown_name("option", name, OPTIONS)
        _check_fields(options)
        found = {"gravity": task.place} | with_level(options)
        arm = ArmConfig.from_dict({name: found[name] for name in found.keys() & OF_ARM})
        own = {name: found[name] for name in found.keys() - OF_ARM if found[name] is not None}
        own = {**DEFAULTS, "fatigue": task.fatigue, **own}
        _check_period(own["control_dt"], arm.timestep)
        own["sensors"] = checked_sensors(own["sensors"])
        usual: VoluntaryControl = _NESTED["control"]
        delay = round(usual.delay / own["control_dt"]) * own["control_dt"]
        groups = {**_NESTED, "control": replace(usual, delay=delay)}
        own |= {name: nested(name, own[name], default) for name, default in groups.items()}
        own["belief"] = _believed(own["belief"], arm, own["sensors"])
        own["reward"] = None if own["reward"] is None else OwnReward(own["reward"])
        setup = cls(arm=arm, **own)
        if setup.faults.stopped and arm.coupling == "none":
            raise InputError(
                f"faults.stopped is {list(setup.faults.stopped)}, and coupling is 'none', where "
                "there are no motors: leave one of them out"
            )
        flag("fatigue", setup.fatigue)
        flag("normalize", setup.normalize)
        setup.control.periods(setup.control_dt)
        return setup


OF_ARM = frozenset(one.name for one in fields(ArmConfig))
OPTIONS = OF_ARM | {one.name for one in fields(Setup)} - {"arm"} | {"level"}
"""Names of the options of an environment; `OF_ARM` are the options of its arm."""

_NESTED: dict[str, Any] = {
    "control": VoluntaryControl(),
    "randomize": Randomization(),
    "sensing": Sensing(),
    "faults": Faults(),
}
DEFAULTS: dict[str, Any] = {
    **{"sensors": DEFAULT_SENSORS, "normalize": False, "history": 1, "control_dt": 0.01},
    **{"belief": None, "reward": None, **{group: {} for group in _NESTED}},
}

_FIELDS = {
    group: {one.name for one in fields(default)}
    for group, default in {**vars(ArmConfig()), **_NESTED}.items()
    if is_dataclass(default)
}
_PATHS = [f"{group}.{name}" for group, names in _FIELDS.items() for name in names]


def _check_fields(options: Mapping[str, Any]) -> None:
    """Refuses a field that its group lacks, with the closest field of all groups as a hint."""
    for group, known in _FIELDS.items():
        value = options.get(group)
        for name in value if isinstance(value, Mapping) else ():
            if name not in known:
                raise unknown_name(f"field of {group}", name, known, elsewhere=_PATHS)


def _believed(given: Any, arm: ArmConfig, sensors: Sequence[str]) -> ArmConfig | None:
    if "belief" in sensors:
        return nested("belief", {} if given is None else given, arm)
    if given is not None:
        raise InputError(
            f"belief is {shown(given)}, and sensors is {list(sensors)}: add 'belief' to sensors"
        )
    return None


def _check_period(control_dt: float, sim_dt: float) -> None:
    within("control_dt", control_dt, 0, PREVIEW[0], " s")
    substeps = round(control_dt / sim_dt)
    if substeps < 1 or abs(substeps * sim_dt - control_dt) > ROUNDING:
        raise InputError(
            f"control_dt is {control_dt} and sim_dt {sim_dt}: control_dt must be a multiple"
        )
    steps = PREVIEW[0] / control_dt
    if abs(steps - round(steps)) > ROUNDING:
        raise InputError(f"control_dt is {control_dt}: it must divide {PREVIEW[0]} s")
