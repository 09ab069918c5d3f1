"""Version 0.1, whose wearer and physics these still are: its traces under scripted actions.

`golden_0_1.npz` was recorded with version 0.1: for every task, coupling, place and suit, with and
without muscle noise, fatigue and learning, observation, reward and info at a few control periods.
The old observation, which showed the intention and exact rates, is put together here.
"""

import itertools
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv, episodes
from activesuit.envs.simulation import simulation
from arms import addresses

TRACES = np.load(Path(__file__).with_name("golden_0_1.npz"))
RECORDED = (0, 1, 2, 10, 50, 120, 200)  # control periods
KEPT = RECORDED[:-1]  # what differs shows before
VARIED = {"control": {"noise": 1.0, "tremor": 0.01, "suit_learning": 0.4}, "fatigue": True}
INFO = (
    *("angle", "assist_energy", "assist_torque", "clipped_actions", "cuff_force"),
    *("dissipated_energy", "fatigue", "human_energy", "human_torque", "motor_load", "rate"),
    *("suit_torque", "target_angle", "time"),
)
FEMALE = {"stature": 1.65, "mass": 60.0, "sex": "female", "strength": 20.0}
CASES = [
    (
        f"{task}/{coupling}/{gravity}/{suit}/{'varied' if varied else 'plain'}",
        task,
        {"coupling": coupling, "gravity": gravity, "suit": suit, **(VARIED if varied else {})},
        100 + number,
    )
    for number, (task, coupling, gravity, suit, varied) in enumerate(
        itertools.product(
            ("ShoulderFlexion", "ElbowFlexion", "ArmTracking"),
            ("rigid", "cuffs", "none"),
            ("earth", "moon", "microgravity"),
            ("mock-suit", "emu-like"),
            (False, True),
        )
    )
] + [
    (
        "extra/oracle",
        "ArmTracking",
        {"side": "left", "tilt": (0.2, -0.1), "payload": {"mass": 2.0}},
        7,
    ),
    (
        "extra/delay",
        "ElbowFlexion",
        {"exo": {"encoder_delay": 0.004}, "control_dt": 0.02, "wearer": FEMALE},
        8,
    ),
    (
        "extra/nosuit",
        "ArmTracking",
        {"suit": "none", "coupling": "cuffs", "misalignment": (0.01, -0.01, 0.005)},
        9,
    ),
]


@pytest.fixture
def one_generator(monkeypatch):
    """As in version 0.1, one generator draws the motion, and then the noise of muscles."""
    current = {}

    def stream(seed, episode, purpose, part=0):
        if purpose == "motion":
            current["rng"] = np.random.default_rng(seed)
        return current["rng"]

    monkeypatch.setattr(episodes, "stream", stream)
    monkeypatch.setattr(simulation, "stream", stream)


def action(step, size):
    return 0.3 * np.sin(0.07 * step + np.arange(size)) + (1.5 if step % 61 == 0 else 0.0)


def old_row(env, reward, info, oracle):
    """Returns observation, reward and info of version 0.1 as one row of numbers."""
    measured = {name: env.episodes.simulation.measured(name)[0] for name in ("preview",)}
    data, model, motors = env.data, env.model, env.episodes.motors
    encoders = data.sensordata[addresses(env).encoders]
    count = 2 * np.pi / 2**14
    rates = [data.sensordata[model.sensor(f"encoder_rate_{joint}").adr[0]] for joint in JOINTS]
    torque = info["assist_torque"][:motors] / addresses(env).peak_torque
    command = env.episodes.simulation.memory.command[0]
    parts = [np.rint(encoders / count) * count, rates, torque, measured["preview"], command]
    if "cuff_force" in info:
        parts.append(np.ravel(info["cuff_force"]))
    if oracle:
        parts.append(info["suit_torque"])
    observation = np.concatenate(parts).astype(np.float32)
    shown = [np.ravel(info[name]) for name in INFO if name in info]
    return np.concatenate([observation, [reward], *shown]).astype(float)


@pytest.mark.parametrize(("name", "task", "options", "seed"), CASES, ids=[c[0] for c in CASES])
@pytest.mark.usefixtures("one_generator")
def test_traces_of_version_0_1(name, task, options, seed):
    env = ArmEnv(task, **options)
    oracle, reward = name == "extra/oracle", 0.0
    _, info = env.reset(seed=seed)
    for step in range(KEPT[-1] + 1):
        if step in KEPT:
            expected = TRACES[name][RECORDED.index(step)]
            np.testing.assert_allclose(
                old_row(env, reward, info, oracle), expected, rtol=1e-9, atol=1e-9
            )
        _, reward, *_, info = env.step(action(step, env.episodes.motors))
