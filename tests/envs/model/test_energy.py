"""Energy: closed forms of the bare arm, and a relaxed arm that only ever loses it.

All energy there is: kinetic and potential energy of MuJoCo, what the springs of the cuffs store,
and what the suit stores: the work done on it less what it has dissipated. With a relaxed wearer and
motors without command nothing supplies any.
"""

from itertools import product

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS, suit_names
from activesuit.envs.model import GRAVITY, ArmConfig, arm_spec, bare_arm
from activesuit.envs.model.config import COUPLINGS, SIDES
from activesuit.envs.person import segments
from arms import PEOPLE, posed
from mujoco.rollout import rollout

KICK = np.array([1.0, 2.0, -2.0, 3.0])  # rad/s
LONG, SHORT = 60.0, 10.0  # s: until nothing moves, and until 90 % of the loss of 60 s is lost
ROUNDING = 1e-8  # J, error of energies around 100 J and of losses over 60,000 steps
SOFTNESS = 4e-3  # J, work of 0.1 mm: MuJoCo's friction gives some energy back at a stop
ENERGIES = {
    name: getattr(mujoco.mjtSensor, f"mjSENS_E_{name}") for name in ("KINETIC", "POTENTIAL")
}


def cases():
    """Each suit with each coupling; gravities, persons and sides take turns."""
    for i, (suit, coupling) in enumerate(product((*suit_names(), "none"), COUPLINGS)):
        fields = {"suit": suit, "coupling": coupling, "side": SIDES[i % 2]}
        turns = {"gravity": list(GRAVITY)[i % len(GRAVITY)], "wearer": PEOPLE[i % len(PEOPLE)]}
        name = f"{suit}-{coupling}"
        yield pytest.param({**fields, **turns}, LONG, marks=pytest.mark.slow, id=f"{name}-long")
        if suit == "mock-suit":
            yield pytest.param(fields, SHORT, id=name)


def relaxed(config):
    """The model without the wearer's muscles, with sensors of energy and of the arm's angles."""
    spec = arm_spec(config)
    muscles = [actuator for actuator in spec.actuators if actuator.name.startswith("human_")]
    meters = [sensor for sensor in spec.sensors if sensor.name.startswith("human_")]
    for part in [*spec.keys, *meters, *muscles]:
        spec.delete(part)
    for name, kind in ENERGIES.items():
        spec.add_sensor(name=name, type=kind)
    for joint in JOINTS:
        sensor = spec.add_sensor(name=f"angle_{joint}", type=mujoco.mjtSensor.mjSENS_JOINTPOS)
        sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_JOINT, joint
    return spec.compile()


def released(model, pose, seconds):
    """Sensor readings of every step after a kick, by name, shape (steps,) each."""
    data = mujoco.MjData(model)
    data.qpos[:] = np.tile(pose, model.nq // len(JOINTS))
    data.qvel[:] = np.tile(KICK, model.nv // len(JOINTS))
    physics = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.empty(mujoco.mj_stateSize(model, physics))
    mujoco.mj_getState(model, data, start, physics)
    steps = round(seconds / model.opt.timestep)
    _, readings = rollout(model, data, start, np.zeros((steps, model.nu)))
    assert not data.warning.number.any()
    return {model.sensor(i).name: readings[0, :, model.sensor_adr[i]] for i in range(model.nsensor)}


def balance(readings):
    """(all energy there is, energy dissipated by the suit) [J] at every step."""
    total = readings["KINETIC"] + readings["POTENTIAL"]
    total = sum((v for k, v in readings.items() if k.startswith("cuff_") and "energy" in k), total)
    dissipated = np.zeros_like(total)
    for joint in JOINTS:
        if f"{joint}_suit_torque" in readings:
            torque, angle = -readings[f"{joint}_suit_torque"], readings[f"angle_{joint}"]
            work = np.cumsum((torque[1:] + torque[:-1]) / 2 * np.diff(angle))
            loss = readings[f"{joint}_suit_dissipated_energy"]
            total = total + np.append(0, work) - loss
            dissipated += loss
    return total, dissipated


@pytest.mark.parametrize(("fields", "seconds"), list(cases()))
def test_a_relaxed_arm_only_loses_energy(fields, seconds):
    model = relaxed(ArmConfig(allow_uncertified=True, **fields))
    for friction, tolerance in ((model.dof_frictionloss.copy(), SOFTNESS), (0.0, ROUNDING)):
        model.dof_frictionloss[:] = friction
        # The pose is where the suit's memory begins: without torque, and with nothing stored.
        total, dissipated = balance(released(model, np.array([0.0, 0.35, 0.52, 0.0]), seconds))
        assert (total - np.minimum.accumulate(total)).max() < tolerance
        assert total[0] - total[-1] > 0.3
        assert np.diff(dissipated).min() > -ROUNDING
        if fields["suit"] != "none":
            assert dissipated[-1] > 0.05


def energies(model, angle, rate):
    """(kinetic, potential) energy [J]."""
    data = posed(model, angle, rate)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return data.energy[1], data.energy[0]


@pytest.mark.parametrize("person", PEOPLE[1:3])
def test_a_bent_elbow_moves_forearm_and_hand(person):
    arm, rate = segments(person), 3.0
    reach = {"forearm": arm["forearm"].center, "hand": arm["forearm"].length + arm["hand"].center}
    inertia = sum(arm[name].inertia[1] + arm[name].mass * r**2 for name, r in reach.items())
    model = bare_arm(ArmConfig(wearer=person))
    kinetic, _ = energies(model, np.zeros(4), [0, 0, rate, 0])
    assert kinetic == pytest.approx(inertia * rate**2 / 2, rel=1e-12)


@pytest.mark.parametrize("side", SIDES)
def test_a_bare_arm_without_friction_and_limits_keeps_its_energy(side):
    model = bare_arm(ArmConfig(side=side))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = 0
    data = mujoco.MjData(model)
    data.qvel[:] = KICK
    before = sum(energies(model, data.qpos, data.qvel))
    mujoco.mj_step(model, data, round(10 / model.opt.timestep))
    after = sum(energies(model, data.qpos, data.qvel))
    assert np.ptp(data.qpos) > 0.1
    assert after == pytest.approx(before, abs=1e-4)
