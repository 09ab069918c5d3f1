"""Policies, references and bounds on the same new motions, and what their scores say."""

import json
from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import BOUNDS, evaluate
from activesuit.envs.evaluation.best_known_plan import clairvoyant, rationed
from activesuit.envs.evaluation.run import reference_options
from activesuit.envs.evaluation.scores import root_mean_square as rms
from activesuit.envs.evaluation.wearers import Wearers
from activesuit.envs.interface.reward import COSTS
from activesuit.envs.model import Exo
from activesuit.envs.plant import Plant
from activesuit.envs.policies import NoAssist, make_policy
from helpers import assert_refused, shorten_tasks, without_volume_shares
from own_policies import Lose, Push
from scipy.optimize import minimize
from scipy.signal import lfilter

ENV = "ActiveSuit/ArmTracking-v0"
MOTIONS = 8
DT = 0.01


@pytest.fixture(scope="module")
def short():
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 1.5)
        yield


@pytest.fixture(scope="module")
def weightless(short):
    """Policies, references and bounds on short motions without gravity."""
    reported = {}
    shipped = ("none", "gravity", "oracle", "feedforward", "compensation")
    policies = {"mine": Push, **{name: name for name in (*shipped, *BOUNDS)}}
    options = {"motions": MOTIONS, "gravity": "microgravity", "threads": 1}
    options["on_policy"] = lambda name, traces: reported.update({name: len(traces)})
    found = evaluate(ENV, policies, **options)
    assert reported == dict.fromkeys(["suited", "unsuited", *policies], MOTIONS)
    return found


def test_references_are_the_scale_of_relief(weightless):
    for name, value in (("suited", 0.0), ("unsuited", 1.0)):
        relief = weightless.relief(name)
        assert relief.value == pytest.approx(value, abs=1e-12)
        assert (relief.low, relief.high) == pytest.approx((value, value), abs=1e-9)
    cost = weightless.suit_cost
    assert 0.015 < cost.low < cost.value < cost.high < 0.2
    suited, none = (np.array(weightless.scores[name].effort) for name in ("suited", "none"))
    unsuited = np.array(weightless.scores["unsuited"].effort)
    by_hand = np.sum(suited - none) / np.sum(suited - unsuited)
    assert weightless.relief("none").value == pytest.approx(by_hand)
    assert by_hand < 0  # friction and inertia of motors that are off


def test_what_each_policy_gives_back(weightless):
    relief = {name: weightless.relief(name).value for name in weightless.scores}
    order = ["mine", "none", "feedforward", "compensation", "best-known-plan"]
    assert sorted(order, key=relief.get) == order
    mine, none, feedforward, _, best = (np.mean(weightless.scores[name].reward) for name in order)
    assert mine < none < feedforward < best
    assert relief["gravity"] == pytest.approx(relief["none"], abs=1e-6)  # nothing has weight
    assert weightless.share_of_bound("feedforward", "clairvoyant-suit").value > 0.6
    assert relief["feedforward"] == pytest.approx(relief["oracle"], abs=0.15)
    assert weightless.share_of_bound("best-known-plan").value == pytest.approx(1)
    by_hand = relief["feedforward"] / relief["best-known-plan"]
    assert weightless.share_of_bound("feedforward").value == pytest.approx(by_hand)
    rows = [("none", "nothing", "unknown policy of this evaluation 'nothing'")]
    assert_refused(weightless.share_of_bound, rows)
    # Without limits and lag of the motors the least torque of the wearer would be zero.
    plan, suited = (
        rms(np.array([trace.human_torque[:, 1:3] for trace in weightless.traces[name]]))
        for name in ("best-known-plan", "suited")
    )
    assert plan < 0.025 * suited


def test_no_policy_exceeds_the_clairvoyant_by_more_than_its_interval(weightless):
    best = np.array(weightless.scores["best-known-plan"].reward)
    least = np.array(weightless.scores["best-known-plan"].effort)
    for name, score in weightless.scores.items():
        if name in ("unsuited", "suited", "best-known-plan"):
            continue
        assert (np.array(score.effort) >= least).all(), name
        ahead = np.array(score.reward) - best
        assert ahead.mean() < 2.4 * ahead.std(ddof=1) / np.sqrt(MOTIONS), name


def test_scores_keep_one_value_per_motion(weightless):
    for name, score in weightless.scores.items():
        assert score.policy == name
        per_motion = [score.effort, score.tracking, score.reward, score.success]
        per_motion += [score.unadapted_effort, score.unadapted_tracking, score.assist_energy]
        per_motion += [*score.torque.values(), *score.costs.values()]
        assert {len(values) for values in per_motion} == {MOTIONS}
        assert set(score.costs) == set(COSTS) and min(score.reward) > 0
        assert max(score.reward) <= 1 and score.failures == 0
    suited = weightless.scores["suited"]
    assert np.mean(suited.tracking) < 0.5 * np.mean(suited.unadapted_tracking)  # they have learned
    assert weightless.scores["none"].success == (True,) * MOTIONS
    assert not any(weightless.scores["suited"].assist_energy)


def test_net_effort_leaves_co_contraction_out(weightless):
    for name, one in weightless.scores.items():
        net, whole = np.array(one.net_effort), np.array(one.effort)
        assert (net < whole).all(), name
        for value, trace in zip(net, weightless.traces[name], strict=True):
            way = np.where(trace.human_torque > 0, trace.strength[:, 1], trace.strength[:, 0])
            assert value == pytest.approx(rms(trace.human_torque / way))
    assert weightless.net_relief("unsuited").value == pytest.approx(1)
    assert weightless.net_relief("suited").value == pytest.approx(0)


def test_an_evaluation_becomes_json(weightless):
    found = json.loads(json.dumps(weightless.to_dict()))
    assert found["adapted"] is True
    assert found["suit_cost"]["value"] == weightless.suit_cost.value
    assert list(found["scores"]) == list(weightless.scores)
    assert found["scores"]["none"]["relief"] == weightless.relief("none").to_dict()


def test_wearers_who_have_learned_nothing_and_two_motions_without_an_interval(short):
    found = evaluate(ENV, ["none", Push], motions=2, adapted=False, threads=1)
    assert list(found.scores) == ["unsuited", "suited", "none", "Push"]
    for score in found.scores.values():
        assert score.effort == score.unadapted_effort
        assert score.tracking == score.unadapted_tracking
    assert not found.adapted
    for ask in (lambda: found.suit_cost, lambda: found.relief("none"), found.to_dict):
        assert_refused(ask, [("at least 8 motions, and there are 2: give more",)])


def test_where_the_suit_costs_too_little_or_is_not_compared_there_is_no_relief(short):
    no_suit = {"suit": "none", "references": False, "motions": 1}
    limp = {"suit": without_volume_shares(load_suit("emu-like")), "pressure": 0.0}
    for options in (no_suit, {**limp, "gravity": "microgravity", "motions": MOTIONS}):
        found = evaluate(ENV, ["none"], adapted=False, threads=1, **options)
        assert found.suit_cost is None or found.suit_cost.value < 0.01
        assert found.relief("none") is None
        if options is no_suit:
            assert found.share_of_bound("none") is None
            assert json.loads(json.dumps(found.to_dict()))["scores"]["none"]["relief"] is None


def test_no_wearer_adapts_to_a_policy_that_loses_the_arm(short):
    weak = {"sex": "female", "stature": 1.5, "mass": 50.0, "strength": 5.0}
    options = {"wearer": weak, "payload": {"mass": 5.0}, "references": False, "motions": 1}
    options["seed"] = 10_000
    found = evaluate(ENV, {"lose": Lose}, adapted=False, **options)
    assert found.scores["lose"].failures == 1
    message = r"loses the arm after .* s \(seed 10000\).*adapted=False"
    assert_refused(lambda: evaluate(ENV, {"lose": Lose}, **options), [(message,)])


def test_references_have_the_same_wearer_but_no_exoskeleton():
    options = {
        **{"suit": "emu-like", "pressure": 0.5, "coupling": "cuffs", "gravity": "moon"},
        **{"misalignment": (0.01, 0, 0), "payload": {"mass": 2.0}, "sensors": ["cuffs"]},
        "randomize": {"misalignment": 0.02, "payload": [0, 3], "loop": [1, 2], "pressure": 0.2},
    }
    kept = {"gravity": "moon", "payload": {"mass": 2.0}, "coupling": "none"}
    drawn = {"payload": [0, 3], "loop": [1, 2], "pressure": 0.2}
    suited = {**kept, "suit": "emu-like", "pressure": 0.5, "randomize": drawn}
    assert reference_options("suited", options) == suited
    unsuited = {**kept, "suit": "none", "randomize": {"payload": [0, 3]}}
    assert reference_options("unsuited", options) == unsuited


@pytest.mark.parametrize("weak", [False, True])
def test_a_plan_rations_the_heat_of_motors(weak):
    rng = np.random.default_rng(1)
    motor = replace(Exo().elbow, peak_torque=9.0, continuous_torque=5.0, thermal_time_constant=0.4)
    remains = np.exp(-DT / 0.4)
    beside = (rng.uniform(30, 60, 60), rng.uniform(0, 6, 60)) if weak else (1.0, 0.0)
    strength, opposed = beside

    def heat(torque):
        return lfilter([1 - remains], [1, -remains], torque**2)

    def effort(torque):
        return np.sum(((np.abs(wanted - torque) + opposed) / strength) ** 2)

    cool = rng.uniform(-4, 4, 60)
    np.testing.assert_array_equal(rationed(cool, motor, DT, *beside), cool)
    wanted = 16 * np.sin(np.linspace(0, 9, 60)) * np.linspace(1, 0.4, 60)
    given = rationed(wanted, motor, DT, *beside)
    assert heat(wanted).max() > 1.5 * 25 and heat(given).max() <= 25
    assert np.abs(given).max() <= 9
    assert (np.abs(given) <= np.abs(wanted)).all()
    best = minimize(
        lambda torque: effort(torque) / effort(0 * wanted),
        given,
        constraints={"type": "ineq", "fun": lambda torque: 25 - heat(torque)},
        bounds=[(-9, 9)] * 60,
        method="SLSQP",
        options={"maxiter": 300},
    )
    assert best.success and effort(given) <= 1.01 * best.fun * effort(0 * wanted)


def test_named_policies_see_units_whatever_others_see(short):
    few = {"motions": 2, "seed": 10_000, "references": False, "adapted": False}
    reported = [
        evaluate(ENV, ["compensation", Push], **few, **options).scores["compensation"].effort
        for options in ({}, {"normalize": True}, {"belief": {}, "sensors": ["encoders", "belief"]})
    ]
    assert len(set(reported)) == 1
    normal, message = ArmEnv(normalize=True), "'compensation' reads angles in rad, and the env"
    assert_refused(make_policy, [("compensation", normal, message)])


def test_mistakes(short):
    rows = [
        (["none"], {"suit": "none"}, "references need a suit, and suit is 'none': name a suit"),
        (["nune"], {}, "unknown policy 'nune'.*'none'"),
        (["none"], {"motions": 0}, "motions is 0"),
        ([], {}, "no policy given"),
        ("none", {}, r"policies is 'none': give a list"),
        (["suited"], {}, "policy 'suited' is a reference without exoskeleton: leave it out"),
        ({"mine": NoAssist, "push": 0.2}, {}, r"policy 'push' is 0\.2: give a name, or a function"),
        (["best-known-plan"], {"coupling": "none"}, "'best-known-plan' needs motors, and coupling"),
        ([NoAssist, NoAssist], {}, "two policies are named 'NoAssist': name each one once"),
        (["none"], {"learned_torque": True}, "evaluate sets learned_torque itself: leave "),
        (["none"], {"settled": False}, "'settled' was a name of version 0.2: write 'adapted'"),
        (["none"], {"on_policy": 5}, "on_policy is 5: give a function"),
    ]
    assert_refused(
        lambda policies, options: evaluate(
            ENV, policies, **{"references": "suit" in options, "motions": 1, **options}
        ),
        rows,
    )


ELBOW = "ActiveSuit/ElbowFlexion-v0"
FEW = {"motions": 2, "references": False, "max_episode_steps": 100}


def test_a_look_at_the_intention_is_refused():
    ways = ("episodes", "unwrapped", "simulation", "get_state")
    rows = [(way, f"a policy asks for '{way}' of the environment: it gets") for way in ways]
    assert_refused(
        lambda way: evaluate(ELBOW, {"peek": lambda plant: getattr(plant, way)}, **FEW), rows
    )


def test_the_plant_says_what_a_controller_may_know():
    env = ArmEnv("ArmTracking", sensors=["encoders", "interaction"], suit="emu-like")
    plant = Plant.of(env.episodes)
    assert plant.layout == env.layout and plant.peak.tolist() == [40.0, 25.0]
    assert (plant.dt, plant.motors, plant.assisted.tolist()) == (0.01, 2, [1, 2])
    plant.peak[:] = 0  # a copy
    assert Plant.of(env.episodes).peak.tolist() == [40.0, 25.0]
    observation, _ = env.reset(seed=0)
    plant = Plant.of(env.episodes)
    one, other = make_policy("compensation", plant), make_policy("compensation", env)
    np.testing.assert_array_equal(one.act(observation), other.act(observation))
    assert not hasattr(plant, "intention")


def test_a_plan_at_the_heat_limit_begins_from_a_policy_too():
    weak = Exo(elbow=replace(Exo().elbow, continuous_torque=2.0, thermal_time_constant=1.0))
    wearers = Wearers(ELBOW, 1, exo=weak, max_episode_steps=100, threads=1)
    seeds = range(10_000, 10_001)
    rivals = wearers.adapted(lambda: make_policy("compensation", wearers.arms), seeds)
    efforts = {name: [] for name in ("alone", "begun")}
    for name, given in (("alone", ()), ("begun", rivals)):
        clairvoyant(wearers, seeds, given=given, on_pass=efforts[name].append)
    wearers.close()
    assert len(efforts["begun"]) > len(efforts["alone"])
    assert efforts["begun"][-1] <= efforts["alone"][-1] + 1e-9
