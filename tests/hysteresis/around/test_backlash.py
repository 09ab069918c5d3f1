"""Models behind play: where contact opens, that no motion gets energy, and the engine."""

import mujoco
import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import (
    Asymmetric,
    Backlash,
    BoucWen,
    Clipped,
    Duhem,
    HingedStops,
    PrandtlIshlinskii,
    Viscoelastic,
    model_from_dict,
)
from activesuit.hysteresis.around import backlash_kernels as kernels
from activesuit.hysteresis.around import sprung
from activesuit.hysteresis.engine import attach, replace_model, same_layout
from activesuit.hysteresis.protocol import follow
from activesuit.identification.lost_motion import played
from helpers import assert_refused, sweep

GAP = 0.05


@pytest.fixture
def joint(elbow):
    return Backlash(model=elbow, gap=GAP)


def rising(elbow):
    """Returns models whose torque rises with the angle, in the motions here."""
    stops = {"stiffness": 0.5, "thresholds": (0.05, 0.2), "weights": (6.0, 4.0)}
    return (
        elbow,
        Clipped(model=elbow, angle_range=(0.6, 1.2)),
        Asymmetric(
            model=Clipped(model=elbow, angle_range=(0.6, 1.2)),
            polynomial=[0.3, 0.5, 0.8],
        ),
        BoucWen(elastic=0.2, hysteretic=4.0, beta=6.0, gamma=2.0, n=1.5),
        PrandtlIshlinskii(**stops),
        HingedStops(**stops, knots=(-0.5, 0.5), slopes=(1.0, 0.2, 2.0)),
        Duhem(spring=(-0.4, 0.6, 0.2), stiffness=9.0, friction_up=1.5, friction_down=2.5),
    )


def test_contact_opens_at_no_torque_and_closes_on_the_other_face(joint):
    angle = sweep(0.52, 1.2, 0.52, samples=4001)
    torque = joint.response(angle)
    free = np.flatnonzero(np.abs(torque[4001:]) <= kernels.ZERO) + 4001
    assert free.size > 100
    assert np.all(np.diff(free) == 1)
    step = angle[1] - angle[0]
    assert angle[free[0]] - angle[free[-1]] == pytest.approx(GAP, abs=2 * step)
    assert torque[free[0] - 1] > 0 > torque[free[-1] + 1]


def test_in_contact_it_is_the_model_at_the_angle_of_the_suit(joint, elbow):
    loading = sweep(0.52, 1.2, samples=500)
    suit = np.maximum(loading - GAP / 2, 0.52)
    np.testing.assert_array_equal(joint.response(loading), elbow.response(suit))
    loaded = joint.response([0.8, 1.0, 0.9], 3.0)
    suit = np.array([0.8, 1.0, 0.9]) - GAP / 2
    np.testing.assert_allclose(loaded, elbow.response(suit, 3.0), rtol=1e-12)
    pulled = joint.response([0.8, 0.7], -3.0)
    np.testing.assert_allclose(pulled, elbow.response([0.8 + GAP / 2, 0.7 + GAP / 2], -3.0))


def test_a_motion_within_the_gap_meets_nothing(joint):
    torque = joint.response(0.8 + 0.49 * GAP * np.sin(np.arange(50)))
    np.testing.assert_array_equal(torque, 0.0)
    assert joint.tangent(joint.start(0.8), 1) == joint.tangent(joint.start(0.8), -1) == 0.0
    touching, _ = joint.step(joint.start(0.8), 0.8 + GAP)
    assert joint.tangent(touching, 1) > 0
    assert joint.energy(joint.start(0.8)).dissipated == 0


def test_a_small_gap_is_the_model_without_play(elbow):
    angle = sweep(0.5, 1.2, 0.6, 1.0, 0.4)
    near = Backlash(model=elbow, gap=1e-7)
    np.testing.assert_allclose(near.response(angle), elbow.response(angle), atol=1e-5)


@pytest.mark.slow
def test_ten_thousand_closed_cycles_give_no_energy_but_what_was_stored(elbow):
    rng = np.random.default_rng(0)
    kinds = rising(elbow)
    for i in range(10_000):
        joint = Backlash(model=kinds[i % len(kinds)], gap=rng.uniform(0.001, 0.4))
        turns = rng.uniform(-0.2, 1.6, rng.integers(2, 6))
        cycle = sweep(*turns, turns[0], samples=100)
        torque = joint.response(np.concatenate([cycle, cycle[1:]]))[cycle.size - 1 :]
        first = follow(joint, joint.start(turns[0]), [*turns[1:], turns[0]])
        last = follow(joint, first, [*turns[1:], turns[0]])
        gained = joint.energy(last).stored - joint.energy(first).stored
        # Trapezoids miss a little where contact opens and closes.
        assert np.trapezoid(torque, cycle) >= gained - 1e-3 * np.abs(torque).max(), joint
        assert joint.energy(last).dissipated >= joint.energy(first).dissipated - 1e-9


@pytest.mark.slow
def test_where_the_torque_falls_the_suit_snaps_across_and_gives_no_energy_either(elbow):
    rng, falling = np.random.default_rng(4), Asymmetric(model=elbow, polynomial=[8.0, -20.0, 4.0])
    snapped = 0
    for _ in range(200):
        joint = Backlash(model=falling, gap=rng.uniform(0.05, 0.4))
        turns = rng.uniform(-0.2, 1.6, rng.integers(2, 6))
        cycle = sweep(*turns, turns[0], samples=300)
        states = [follow(joint, joint.start(turns[0]), cycle[1:])]
        for angle in cycle[1:]:
            states.append(joint.step(states[-1], angle)[0])
        torques = np.array([state.torque for state in states])
        ends = np.array([state.memory[-1] for state in states])
        snapped += np.count_nonzero(np.abs(np.diff(ends)) > 0.04)
        gained = joint.energy(states[-1]).stored - joint.energy(states[0]).stored
        most = np.maximum(torques[1:] * np.diff(cycle), torques[:-1] * np.diff(cycle)).sum()
        assert most >= gained
    assert snapped > 20


def test_the_work_is_what_the_model_takes(elbow):
    rng = np.random.default_rng(1)
    for model in rising(elbow):
        for _ in range(20):
            joint = Backlash(model=model, gap=rng.uniform(0.001, 0.4))
            turns = rng.uniform(0.0, 1.6, 4)
            angle = sweep(*turns, samples=2000)
            first = last = joint.start(turns[0])
            for turn in turns[1:]:
                last, _ = joint.step(last, turn)
            change = np.subtract(joint.energy(last), joint.energy(first)).sum()
            work = np.trapezoid(joint.response(angle), angle)
            assert work == pytest.approx(change, abs=1e-5)
            assert joint.energy(last).dissipated >= -1e-9


def test_play_before_a_model_would_give_energy(elbow):
    cycle = sweep(0.7, 1.0, 0.7, samples=2000)
    angle = np.concatenate([[0.52], np.tile(cycle, 4)])
    last = slice(-cycle.size, None)
    before = elbow.response(played(angle, GAP))
    assert np.trapezoid(before[last], angle[last]) == pytest.approx(-0.0685, abs=1e-4)
    behind = Backlash(model=elbow, gap=GAP).response(angle)
    assert np.trapezoid(behind[last], angle[last]) > 0


def test_it_goes_around_models_and_through_a_dictionary(elbow):
    inner = Asymmetric(model=Clipped(model=elbow, angle_range=(0.6, 1.2)), polynomial=[0.1, 0.2])
    joint = Viscoelastic(model=Backlash(model=inner, gap=GAP), damping=0.1)
    assert model_from_dict(joint.to_dict()) == joint
    angle = sweep(0.5, 1.3, 0.5, 0.9)
    slow, time = joint.response(angle), np.arange(angle.size) * 0.01
    np.testing.assert_array_equal(slow, joint.model.response(angle))
    more = joint.response(angle, time=time) - slow
    np.testing.assert_allclose(more, 0.1 * np.gradient(angle, time), atol=1e-12)
    line = sprung(joint, 0.5, 2.0)
    assert line.model.gap == GAP
    assert line.model.model.polynomial == (0.6, 2.2)
    assert sprung(Backlash(model=elbow, gap=GAP), 0.5, 2.0).model.polynomial == (0.5, 2.0)


def test_the_certificate_is_that_of_what_the_suit_can_reach(elbow, shoulder):
    joint = Backlash(model=elbow, gap=0.2)
    assert joint.certificate() == elbow.certificate()
    wide = elbow.certificate((0.4, 1.6))
    assert joint.certificate((0.5, 1.5)).torque_bound == wide.torque_bound
    assert joint.certificate((0.5, 1.5)).angle_range == (0.5, 1.5)
    assert joint.free_parameters == 6
    kept = Clipped(model=shoulder, angle_range=(0.35, 1.22))
    far, near = kept.start(0.8, 30.0), kept.start(0.8, 0.0)
    behind = Backlash(model=kept, gap=0.0001)
    for state in (far, near):
        same = behind.start(0.8, state.torque)
        assert behind.start_is_certified(same) == kept.start_is_certified(state)


def test_many_memories_are_moved_as_one(joint):
    rng = np.random.default_rng(2)
    states = [joint.start(angle, torque) for angle, torque in rng.uniform(0.5, 1, (6, 2))]
    memories = np.array([state.memory for state in states])
    here, soon = rng.uniform(0.4, 1.4, (2, 6))
    ahead = joint.advance(memories, here, soon)
    for i, state in enumerate(states):
        moved, _ = joint.step(state, here[i])
        np.testing.assert_array_equal(memories[i], moved.memory)
        assert ahead[i] == joint.step(moved, soon[i])[1]


def test_wrong_gaps_are_refused(elbow):
    wrong = [0.0, -0.1, np.nan, np.inf, "x"]
    assert_refused(lambda gap: Backlash(model=elbow, gap=gap), [(one, "gap is") for one in wrong])


def test_wrong_orders_are_refused(joint, elbow):
    for model in (joint, Viscoelastic(model=elbow, damping=0.1), "elbow"):
        with pytest.raises(
            InputError, match="bare, `Clipped` or `Asymmetric`; put a dashpot around"
        ):
            Backlash(model=model, gap=GAP)
    with pytest.raises(InputError, match="give one hysteresis model, bare or `Clipped`"):
        Asymmetric(model=joint, polynomial=[0.1])
    with pytest.raises(InputError, match="give one hysteresis model without another"):
        Clipped(model=joint, angle_range=(0, 1))


def test_a_pole_on_the_way_is_reported(shoulder):
    joint = Backlash(model=shoulder, gap=GAP)
    assert not joint.certificate().certified
    with pytest.raises(InputError, match="torque becomes infinite between"):
        joint.response(sweep(0.35, 3.0, -3.0, 3.0))


HINGE = """<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody><body>
  <joint name="j" ref="0.8" armature="0.5"/><geom size=".1"/></body></worldbody></mujoco>"""


def compiled(joint, **options):
    spec = mujoco.MjSpec.from_string(HINGE)
    attach(spec, "j", joint, start_angle=0.8, **options)
    return spec.compile()


def simulated(joint, steps=4000, step=1e-3, **options):
    """Returns angle, resistance, sensed stiffness and energy of a hinge along a given motion."""
    model = compiled(joint, **options)
    model.opt.timestep = step
    data, found = mujoco.MjData(model), []
    data.qpos[0] = 0.8
    for i in range(steps):
        wanted = 0.8 + 0.5 * np.sin(3 * i * step)
        data.qfrc_applied[0] = 400 * (wanted - data.qpos[0]) - 30 * data.qvel[0]
        mujoco.mj_forward(model, data)
        found.append([data.qpos[0], -data.qfrc_passive[0], *data.sensordata])
        mujoco.mj_step(model, data)
    return np.array(found).T


def test_the_engine_is_response(elbow):
    crossed = 0
    for model in rising(elbow):
        for start in (0.0, 0.4):
            joint = Backlash(model=model, gap=GAP)
            angle, torque, sensed, *_ = simulated(joint, start_torque=start)
            np.testing.assert_array_equal(torque, -sensed)
            expected = joint.response(np.concatenate([[0.8], angle]), start)[1:]
            np.testing.assert_allclose(torque, expected, atol=1e-9)
            free = np.abs(torque) <= kernels.ZERO
            crossed += free[0] != free[-1] or np.any(np.diff(free))
            assert np.ptp(torque) > 0.5
    assert crossed >= 8


def test_the_sensors_tell_stiffness_and_energy(joint):
    angle, torque, _, stiffness, lost = simulated(joint)
    free = np.abs(torque) <= kernels.ZERO
    assert np.all(stiffness[free][5:-5] == 0)
    assert np.all(stiffness[~free] > 0)
    assert np.all(np.diff(lost) >= -1e-8)
    state = joint.start(0.8)
    for one in angle:
        state, _ = joint.step(state, one)
    assert lost[-1] == pytest.approx(joint.energy(state).dissipated, abs=1e-9)


def test_a_dashpot_around_play_resists_in_the_gap(joint):
    damped = Viscoelastic(model=joint, damping=0.2)
    model = compiled(damped)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 0.8, 0.5
    mujoco.mj_forward(model, data)
    assert -data.qfrc_passive[0] == pytest.approx(0.1)


def test_a_start_path_a_reset_and_a_replaced_model(joint, elbow):
    path = (1.2, 0.9, 1.0)
    model = compiled(joint, start_path=path, start_torque=0.3)
    data = mujoco.MjData(model)
    fresh, begun = data.plugin_state.copy(), follow(joint, joint.start(0.8, 0.3), path)
    np.testing.assert_array_equal(fresh[-kernels.SIZE :], [GAP, begun.memory[-1]])
    size = elbow.memory_size
    np.testing.assert_allclose(fresh[1 : 1 + size], begun.memory[:-1], rtol=1e-12)
    data.qvel[0] = 1.0
    mujoco.mj_step(model, data, 50)
    assert not np.array_equal(data.plugin_state, fresh)
    mujoco.mj_resetData(model, data)
    np.testing.assert_array_equal(data.plugin_state, fresh)
    replace_model(model, data.plugin_state, "j", joint.scaled(torque=2.0))
    assert data.plugin_state[-2] == GAP
    replace_model(model, data.plugin_state, "j", joint)
    np.testing.assert_allclose(data.plugin_state, fresh, rtol=1e-12)
    with pytest.raises(InputError, match="another kind or size"):
        replace_model(model, data.plugin_state, "j", elbow)
    assert not same_layout(joint, elbow)


def test_a_gap_that_a_user_wrote_into_the_state_is_not_followed(joint):
    for wrong in (-1.0, 0.0, np.nan):
        model = compiled(joint)
        data = mujoco.MjData(model)
        data.plugin_state[-2], data.qvel[0] = wrong, 1.0
        mujoco.mj_step(model, data, 5)
        assert data.plugin_state[0] == 1
        assert np.isfinite(data.qpos[0])
