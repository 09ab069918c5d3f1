"""The time of a physics step with suit and wearer, and the accuracy of longer steps."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import mujoco
import numpy as np

from ..arrays import Array
from ..assets import JOINTS, load_suit
from ..envs.model import ArmConfig, arm_spec, bare_arm, compose
from ..envs.model.config import COUPLINGS
from ..envs.simulation.episode_plan import Motion
from ..envs.simulation.inverse_dynamics import Chain, arm_torques
from ..envs.simulation.structs import Addresses
from ..envs.tasks import ARM_TRACKING
from .timing import Row, compare

STEPS = 1000
TARGET = 0.85
FINEST = 0.000125  # s, the step that others are compared with
TIME_STEPS = {  # s; cuffs do not bear longer ones
    "rigid": (0.00025, 0.0005, 0.001, 0.002, 0.004),
    "cuffs": (0.00025, 0.0005, 0.001, 0.002),
}
PERIOD = 0.02  # [s], time between two intentions and two readings: a multiple of all steps
SETTLED = 50  # number of periods until the wearer carries an unforeseen load
SEED = 0


def rows(repeats: int) -> list[Row]:
    """Times a step of each coupling against the same chain with neither suit nor wearer."""
    found = []
    for coupling in COUPLINGS:
        # The wearer moves from home to reach; without gravity, a chain that nobody holds stays off
        # the ends of its ranges.
        config = ArmConfig.from_dict({"coupling": coupling, "gravity": "microgravity"})
        row = compare(
            f"coupling {coupling!r}, with suit and wearer",
            _stepper(compose(config)),
            "the same chain with neither",
            _stepper(_chain(config)),
            repeats=repeats,
            unit="us/step",
            count=STEPS,
            target=TARGET if coupling == "rigid" else None,
        )
        found.append(row)
    return found


def _chain(config: ArmConfig) -> mujoco.MjModel:
    """Returns the model of `config` with a suit that does not resist, and without a wearer."""
    limp = load_suit(config.suit).model_copy(update={"joints": {}})
    with TemporaryDirectory() as folder:
        limp.save(Path(folder) / "limp.json")
        spec = arm_spec(replace(config, suit=str(Path(folder) / "limp.json")))
    wearer = [actuator for actuator in spec.actuators if actuator.name.startswith("human_")]
    meters = [sensor for sensor in spec.sensors if sensor.name.startswith("human_")]
    for key in spec.keys:  # the motors' controls are the last
        key.ctrl = list(key.ctrl)[3 * len(wearer) :]
    for part in [*meters, *wearer]:
        spec.delete(part)
    return spec.compile()


def _stepper(model: mujoco.MjModel) -> Callable[[], None]:
    data = mujoco.MjData(model)

    def run() -> None:
        mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
        data.ctrl[:] = model.key("reach").ctrl
        mujoco.mj_step(model, data, STEPS)

    return run


@dataclass(frozen=True, kw_only=True)
class StepError:
    """Error of a physics step, as RMS differences from a step of 0.125 ms.

    Attributes:
        coupling: Coupling of the exoskeleton.
        time_step: Physics step [s].
        human: Error of the wearer's torque [N·m], the largest of the joints.
        suit: Error of the suit's torque [N·m], the largest of the joints.
        angle: Error of the joint angles [rad], the largest of the joints.
    """

    coupling: str
    time_step: float
    human: float
    suit: float
    angle: float

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def step_errors() -> list[StepError]:
    """Compares physics steps over 9 s of arm tracking on Earth, with the intention of seed 0.

    The wearer has the position and velocity gains of the actuators and the bare arm's feed-forward;
    motors are off.
    """
    found = []
    for coupling, time_steps in TIME_STEPS.items():
        exact = _torques(coupling, FINEST)
        for time_step in time_steps:
            difference = (_torques(coupling, time_step) - exact)[:, SETTLED:]
            human, suit, angle = np.sqrt(np.mean(difference**2, axis=1)).max(axis=1).tolist()
            error = StepError(
                coupling=coupling, time_step=time_step, human=human, suit=suit, angle=angle
            )
            found.append(error)
    return found


def step_table(errors: Sequence[StepError]) -> tuple[list[str], list[list[str]]]:
    """Returns the table of the errors: header and rows."""
    rows = [
        [
            error.coupling,
            f"{1000 * error.time_step:g}",
            f"{error.human:.2g}",
            f"{error.suit:.2g}",
            f"{1000 * error.angle:.2g}",
        ]
        for error in errors
    ]
    header = [
        "coupling",
        "step\n[ms]",
        "human torque\n[N·m]",
        "suit torque\n[N·m]",
        "angle\n[mrad]",
    ]
    return header, rows


def _torques(coupling: str, time_step: float) -> Array:
    """Returns the wearer's torque, the suit's torque and the angle, shape (3, periods, joints)."""
    config = ArmConfig.from_dict({"coupling": coupling, "sim_dt": time_step})
    model = compose(config)
    data, addresses = mujoco.MjData(model), Addresses.of(model)
    angle, rate, acceleration = _intention()
    feedforward = arm_torques(Chain.of(bare_arm(config)), angle, rate, acceleration)
    data.qpos[:] = np.tile(angle[0], model.nq // len(JOINTS))
    substeps = round(PERIOD / time_step)
    found = np.zeros((3, len(angle), len(JOINTS)))
    for i in range(len(angle)):
        mujoco.mj_forward(model, data)
        found[0, i] = data.actuator_force[addresses.human]
        found[1, i, addresses.suited] = data.sensordata[addresses.suit_torque]
        found[2, i] = data.qpos[addresses.joints]
        data.ctrl[addresses.intention] = angle[i], rate[i], feedforward[i]
        mujoco.mj_step(model, data, substeps)
    return found


def _intention() -> Motion:
    samples = round(ARM_TRACKING.duration / PERIOD) + 1
    return ARM_TRACKING.motion(np.random.default_rng(SEED), samples, PERIOD)
