import copy
import json
import pickle
from dataclasses import asdict
from pathlib import Path

import mujoco
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.person.anthropometry import Person, segments
from activesuit.envs.person.control import (
    PROVENANCE,
    VoluntaryControl,
    start_control,
    voluntary_torque,
)
from activesuit.envs.person.fatigue import fatigue_step, muscle_load
from activesuit.envs.person.strength import isometric_strength, strength_limits
from activesuit.errors import InputError
from activesuit.hysteresis import JilesAtherton

ARM = Path(__file__).parents[3] / "assets" / "mjcf" / "arm.xml"
DT = 0.01
ZERO = np.zeros(4)
FREE = (np.full(4, -np.inf), np.full(4, np.inf))
VALUE = {quantity.name: quantity.value for quantity in PROVENANCE}
NOISE = np.array([VALUE[f"control.noise.{joint}"] for joint in JOINTS])


def pull(settings, state, *, dt=DT, rng=None, **torques):
    given = {"intrinsic": ZERO, "feedforward": ZERO, "suit_resistance": ZERO, "limits": FREE}
    rng = np.random.default_rng(0) if rng is None else rng
    return voluntary_torque(settings, state, dt=dt, rng=rng, **(given | torques))


def shipped_arm():
    """Gains of the wearer's impedance and inertia about every joint of the arm held straight."""
    model = mujoco.MjModel.from_xml_path(str(ARM))
    data, inertia = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    human = [model.actuator(f"human_{joint}").id for joint in JOINTS]
    gains = -model.actuator_biasprm[human, 1], -model.actuator_biasprm[human, 2]
    return *gains, np.diag(inertia)[[model.joint(joint).dofadr[0] for joint in JOINTS]]


def bare_inertia(person):
    result = []
    for first in (0, 0, 1, 2):
        total = reach = 0.0
        for part in list(segments(person).values())[first:]:
            total += part.inertia[1] + part.mass * (reach + part.center) ** 2
            reach += part.length
        result.append(total)
    return np.array(result)


def inertias(count):
    """From a small woman's bare, folded arm to a big man's with suit, exoskeleton and 5 kg."""
    *_, equipped = shipped_arm()
    big = Person.percentile("male", 95)
    lengths = [segment.length for segment in segments(big).values()]
    grip = np.array([sum(lengths), sum(lengths), sum(lengths[1:]), lengths[2]])
    heaviest = equipped - bare_inertia(Person()) + bare_inertia(big) + 5 * grip**2
    lightest = bare_inertia(Person.percentile("female", 5)) / 3
    return np.geomspace(lightest, heaviest, count)


def test_the_default_wearer_adds_the_feedforward_and_delayed_feedback():
    settings, rng = VoluntaryControl(), np.random.default_rng(0)
    untouched = copy.deepcopy(rng.bit_generator.state)
    own, suit, error = np.array([[1.0, 2, 3, 4], [9, 9, 9, 9], [5, -5, 5, -5]])
    state = start_control(settings, 10 * error, DT)
    torque, _ = pull(
        settings, state, intrinsic=error, feedforward=own, suit_resistance=suit, rng=rng
    )
    np.testing.assert_allclose(torque, own + 0.4 * 10 * error)
    assert rng.bit_generator.state == untouched
    learned = VoluntaryControl(suit_learning=0.25, feedback=0)
    torque, _ = pull(learned, state, feedforward=own, suit_resistance=suit)
    np.testing.assert_allclose(torque, own + 0.25 * suit)


@pytest.mark.parametrize(
    ("delay", "dt", "samples"), [(0, 0.01, 0), (0.05, 0.01, 5), (0.13, 0.01, 13), (0.05, 0.002, 25)]
)
def test_feedback_comes_after_the_delay(delay, dt, samples):
    settings = VoluntaryControl(delay=delay, feedback=0.5)
    state, answers = start_control(settings, ZERO, dt), []
    for step in range(40):
        intrinsic = np.full(4, 8.0 * (step == 3))
        torque, state = pull(settings, state, intrinsic=intrinsic, dt=dt)
        answers.append(torque)
    expected = np.zeros((40, 4))
    expected[3 + samples] = 4
    np.testing.assert_array_equal(answers, expected)


def test_all_of_it_stays_within_the_strength_that_fatigue_has_left():
    rng = np.random.default_rng(1)
    settings = VoluntaryControl(suit_learning=1, noise=5, tremor=0.1)
    strength = isometric_strength(Person.percentile("female", 5))
    fatigued, state = np.zeros((200, 2, 4)), start_control(settings, np.zeros((200, 4)), DT)
    weakest, saturated = np.inf, 0
    for _ in range(100):
        angle, rate = rng.uniform(0, 1.5, (200, 4)), rng.uniform(-5, 5, (200, 4))
        limits = strength_limits(strength * (1 - fatigued), angle, rate)
        intrinsic, own, suit = rng.normal(0, 30, (3, 200, 4))
        torque, state = pull(
            settings,
            state,
            intrinsic=intrinsic,
            feedforward=own,
            suit_resistance=suit,
            limits=limits,
            rng=rng,
        )
        total = intrinsic + torque
        assert (total >= limits[0] - 1e-10).all()
        assert (total <= limits[1] + 1e-10).all()
        saturated += np.isclose(total, limits[1]).sum()
        load = muscle_load(total, strength_limits(strength, angle, rate))
        fatigued = fatigue_step(fatigued, load, 10 * DT)
        weakest = min(weakest, 1 - fatigued.max())
    assert saturated > 1000
    assert weakest < 0.97


@pytest.mark.parametrize("dt", [0.01, 0.002])
def test_noise_has_the_stated_size_and_spectrum_at_any_control_rate(dt):
    settings, rng = VoluntaryControl(noise=1, delay=0), np.random.default_rng(2)
    own, still = np.array([10.0, -40, 5, 2]), np.zeros((8000, 4))
    state, noise = start_control(settings, still, dt), []
    for _ in range(round(0.5 / dt)):
        torque, state = pull(settings, state, intrinsic=still, feedforward=own, dt=dt, rng=rng)
        noise.append(torque - own)
    noise = np.array(noise[-round(0.06 / dt) :])
    expected = NOISE * np.abs(own)
    # Five standard errors of 8,000 wearers.
    np.testing.assert_allclose(noise[-1].std(axis=0), expected, rtol=5 / np.sqrt(2 * 8000))
    assert (np.abs(noise[-1].mean(axis=0)) < 5 * expected / np.sqrt(8000)).all()
    lag = round(0.04 / dt)
    correlation = np.mean(noise[-1] * noise[-1 - lag], axis=0) / expected**2
    np.testing.assert_allclose(correlation, np.exp(-2 * np.pi * 4 * 0.04), atol=5 / np.sqrt(8000))


def test_tremor_has_the_stated_size_and_half_its_power_from_8_to_12_hertz():
    settings, rng = VoluntaryControl(tremor=0.02), np.random.default_rng(3)
    own = np.array([10.0, -40, 5, 2])
    state, tremor = start_control(settings, ZERO, DT), []
    for _ in range(20_000):
        torque, state = pull(settings, state, feedforward=own, rng=rng)
        tremor.append(torque - own)
    tremor = np.array(tremor[100:])
    np.testing.assert_allclose(tremor.std(axis=0), 0.02 * np.abs(own), rtol=0.05)
    power = np.abs(np.fft.rfft(tremor, axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(tremor), DT)
    band = (frequency >= 8) & (frequency <= 12)
    np.testing.assert_allclose(power[band].sum(axis=0) / power.sum(axis=0), 0.5, atol=0.05)
    below = power[(frequency >= 9) & (frequency < 11)].sum(axis=0)
    assert (below > power[(frequency >= 5) & (frequency < 7)].sum(axis=0)).all()
    assert (below > power[(frequency >= 13) & (frequency < 15)].sum(axis=0)).all()


@pytest.mark.parametrize(("suit_learning", "error"), [(1.0, 0.0), (0.0, 1.0)])
def test_who_has_learned_the_suit_leaves_nothing_for_feedback(suit_learning, error):
    suit = JilesAtherton(Ms=11.4488, a=128.97, alpha=-0.0515, c=6.4043, k=23.0945, angle_unit="deg")
    settings = VoluntaryControl(suit_learning=suit_learning)
    stiffness, damping, inertia = 120.0, 10.0, 0.2
    own = 1.5 * np.sin(np.arange(300) * DT * 4)
    rate = np.cumsum(own) * DT / inertia
    angle = 1 + np.cumsum(rate) * DT
    intended = np.concatenate([[1.0], angle])
    resistance = suit.response(intended)
    here, speed, worst = 1.0, 0.0, 0.0
    memory, moment = suit.start(1.0, 0.0), 0.0
    state = start_control(settings, ZERO, DT)
    for i in range(300):
        intended_rate = rate[i - 1] if i else 0.0
        intrinsic = stiffness * (intended[i] - here) + damping * (intended_rate - speed)
        torque, state = pull(
            settings,
            state,
            intrinsic=np.full(4, intrinsic),
            feedforward=np.full(4, own[i]),
            suit_resistance=np.full(4, resistance[i]),
        )
        worst = max(worst, abs(intrinsic), abs(torque[2] - own[i] - suit_learning * resistance[i]))
        speed += DT * (intrinsic + torque[2] - moment) / inertia
        here += DT * speed
        memory, moment = suit.step(memory, here)
    assert np.ptp(resistance) > 3
    if error == 0:
        assert worst < 1e-6
    else:
        assert worst > 1


def test_default_feedback_is_stable_for_any_delay():
    stiffness, damping, _ = shipped_arm()
    frequency = np.geomspace(0.01, 5000, 20_000)[:, None]
    impedance = stiffness + 1j * frequency * damping
    settings = VoluntaryControl()
    for inertia in inertias(30):
        loop = settings.feedback * np.abs(impedance / (impedance - inertia * frequency**2))
        assert (loop.max(axis=0) < 1 / 1.5).all()  # never 1: no delay makes it unstable


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1, 0.2])
def test_a_step_settles_for_every_person_and_load(delay):
    stiffness, damping, _ = shipped_arm()
    settings, inertia = VoluntaryControl(delay=delay), inertias(12)
    angle, rate = np.zeros(inertia.shape), np.zeros(inertia.shape)
    state, largest = start_control(settings, np.zeros(inertia.shape), DT), 0.0
    for _ in range(800):
        intrinsic = stiffness * (0.1 - angle) - damping * rate
        torque, state = pull(settings, state, intrinsic=intrinsic)
        for _ in range(50):
            force = stiffness * (0.1 - angle) - damping * rate + torque
            rate = rate + DT / 50 * force / inertia
            angle = angle + DT / 50 * rate
        largest = max(largest, angle.max())
    assert largest < 0.2
    np.testing.assert_allclose(angle, 0.1, atol=1e-4)
    np.testing.assert_allclose(rate, 0, atol=1e-3)


def test_a_branch_repeats_bit_for_bit():
    settings = VoluntaryControl(noise=1, tremor=0.01)
    rng, torques = np.random.default_rng(4), np.random.default_rng(5).normal(size=(60, 4))

    def run(state, rng, steps):
        result = []
        for i in steps:
            torque, state = pull(
                settings, state, intrinsic=torques[i], feedforward=torques[-i], rng=rng
            )
            result.append(torque)
        return np.array(result), state

    _, state = run(start_control(settings, ZERO, DT), rng, range(30))
    saved, random = pickle.dumps(state), copy.deepcopy(rng)
    first, _ = run(state, rng, range(30, 60))
    again, _ = run(state, copy.deepcopy(random), range(30, 60))
    restored, _ = run(pickle.loads(saved), random, range(30, 60))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(first, restored)


@pytest.mark.parametrize("own_generators", [False, True])
def test_many_wearers_at_once_are_those_one_by_one_bit_for_bit(own_generators):
    settings, count = VoluntaryControl(suit_learning=0.5, noise=1, tremor=0.02), 17
    limits = (np.full(4, -40.0), np.full(4, 40.0))
    inputs = np.random.default_rng(6)
    together = start_control(settings, np.zeros((count, 4)), DT)
    alone = [start_control(settings, ZERO, DT) for _ in range(count)]

    def generators():
        if own_generators:
            return [np.random.default_rng(i) for i in range(count)]
        return np.random.default_rng(7)

    rng, same = generators(), generators()
    for _ in range(30):
        names = ("intrinsic", "feedforward", "suit_resistance")
        torques = dict(zip(names, inputs.normal(0, 20, (3, count, 4)), strict=True))
        expected, together = pull(settings, together, limits=limits, rng=rng, **torques)
        for i in range(count):
            mine = {name: torque[i] for name, torque in torques.items()}
            own = same[i] if own_generators else same
            torque, alone[i] = pull(settings, alone[i], limits=limits, rng=own, **mine)
            np.testing.assert_array_equal(torque, expected[i])


def test_settings_convert_to_json_and_back():
    settings = VoluntaryControl(suit_learning=0.3, noise=1)
    assert VoluntaryControl(**json.loads(json.dumps(asdict(settings)))) == settings


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"suit_learning": 1.1}, "suit_learning is 1.1: give it as a share .* from 0 to 1"),
        ({"delay": -0.01}, "delay is -0.01: give it in s, from 0 to 0.5"),
        ({"delay": 50}, "delay is 50: give it in s"),
        ({"feedback": 2}, "feedback is 2"),
        ({"noise": float("nan")}, "noise is nan"),
        ({"tremor": "0.1"}, "tremor is '0.1': give it as a fraction"),
    ],
)
def test_mistakes_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        VoluntaryControl(**settings)


def test_a_delay_between_two_control_periods_is_refused():
    with pytest.raises(InputError, match=r"delay is 0.055 s.*0.01 s, such as 0.06 s"):
        start_control(VoluntaryControl(delay=0.055), ZERO, DT)
