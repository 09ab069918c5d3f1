"""What differs from episode to episode: drawn by seed, and each term for itself."""

import pickle
from itertools import product

import numpy as np
import pytest
from activesuit.assets import JOINTS, Softening, Suit, load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.domain.levels import LEVELS, with_level
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.evaluation.run import reference_options
from activesuit.envs.model import ArmConfig, suit_of_config
from activesuit.hysteresis import Asymmetric, BoucWen, Clipped, PrandtlIshlinskii
from arms import assert_same_states, go_on, reported

ELBOW = JOINTS.index("elbow_flexion")
ENTRY = load_suit("mock-suit").joints["elbow_flexion"]
MODEL = ENTRY.model
WEARERS = [{"sex": "female", "stature": 1.5, "mass": 48.0}, {"strength": 80.0}]
LOW = ENTRY.range[0]
SAMPLES = tuple(MODEL.scaled(torque=factor) for factor in (0.5, 0.8, 1.6))
KINDS = (  # as an ensemble of `identify` with method "auto" draws them
    PrandtlIshlinskii(stiffness=40.0, thresholds=[0.2], weights=[9.0], rest_angle=LOW),
    BoucWen(elastic=2.0, hysteretic=8.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=LOW),
)


def suit_of(**changes):
    joints = {"elbow_flexion": ENTRY.model_copy(update=changes)}
    return Suit(name="s", description="of a test", joints=joints)


SAMPLED = suit_of(samples=SAMPLES)  # samples that cannot be mistaken for each other


@pytest.mark.parametrize("samples", [SAMPLES, KINDS], ids=["scaled", "kinds"])
def test_drawn_suits_appear_in_the_torque_of_their_rows(samples):
    options = {"sensors": ["encoders", "privileged"], "randomize": {"suit": "samples"}}
    arms = ArmEnv(suit=suit_of(samples=samples), **options).rows(24, info="full")
    observation, info = arms.reset(seed=0)
    shown = observation[:, arms.layout["suit_torque"]]
    np.testing.assert_allclose(shown, info["suit_torque"], rtol=1e-6)
    moved, drawn = reported(arms, np.zeros((60, 24, 2))), set()
    both = (np.vstack([info[name][None], moved[name]]) for name in ("angle", "suit_torque"))
    for angle, torque in zip(*(values[..., ELBOW].T for values in both), strict=True):
        errors = [
            np.abs(torque + model.response(np.append(ENTRY.start_angle, angle))[1:]).max()
            for model in (MODEL, *samples)
        ]
        # The physics sees five positions per sample, so that reversals differ a little.
        assert min(errors) < 0.02 and sorted(errors)[1] > 0.1
        assert np.abs(torque[0]) > 0.01  # the first observation already belongs to the suit
        drawn.add(int(np.argmin(errors)))
    assert drawn == set(range(len(samples) + 1))


def test_pressure_scales_the_share_of_the_gas_where_it_is_known():
    suit = suit_of(volume_share=0.5)
    gas = suit.joints["elbow_flexion"]
    env = ArmEnv(suit=suit, randomize={"pressure": 0.5})
    changes = []
    for seed in range(4):
        _, info = env.reset(seed=seed)
        angle = info["angle"][ELBOW]
        drawn = env.episodes._start(0).suit["elbow_flexion"]
        assert drawn.model.model == MODEL
        assert info["suit_torque"][ELBOW] == pytest.approx(-drawn.response([angle])[0], abs=1e-9)
        changes.append(drawn.response([1.5])[0] / gas.response([1.5])[0])
    assert min(changes) < 1 < max(changes)


def test_a_preconditioned_suit_is_drawn_with_its_memory():
    terms = {"suit": "samples", "pressure": 0.3}
    env = ArmEnv(suit=SAMPLED, preconditioned=True, randomize=terms)
    drawn = []
    for seed in range(6):
        _, info = env.reset(seed=seed)
        angle = info["angle"][ELBOW]
        entry = env.episodes._start(0).suit["elbow_flexion"]
        assert info["suit_torque"][ELBOW] == pytest.approx(-entry.response([angle])[0], abs=1e-9)
        virgin = entry.model_copy(update={"start_path": ()})
        assert abs(info["suit_torque"][ELBOW] + virgin.response([angle])[0]) > 0.01
        drawn.append(entry.model.Ms)
    assert len(set(drawn)) == 6


def test_encoder_offsets_are_seen_by_the_controller_only():
    exact, off = ArmEnv(), ArmEnv(randomize={"encoder_offset": 0.05})
    errors = []
    for seed in range(10):
        (seen, info), (wrong, reported) = exact.reset(seed=seed), off.reset(seed=seed)
        np.testing.assert_array_equal(info["angle"], reported["angle"])
        errors.append((wrong - seen)[exact.layout["angle"]])
    assert np.abs(errors).max() <= 0.05 + 2 * np.pi / 2**14
    assert np.ptp(errors, axis=0).min() > 0.03


@pytest.mark.parametrize(
    "terms",
    [
        {"payload": [0.0, 4.0], "gravity": ["earth", "moon", "microgravity"]},
        {"wearers": WEARERS, "misalignment": 0.03, "payload": [0.0, 3.0]},
    ],
    ids=["load and place", "wearer and misalignment"],
)
def test_what_is_drawn_is_that_of_an_environment_made_with_it(terms):
    drawn, met = ArmEnv(coupling="cuffs", randomize=terms, payload={"mass": 1.0}), set()
    for seed in range(4):
        drawn.reset(seed=seed)
        start = drawn.episodes._start(0)
        met.add((start.gravity, start.wearer))
        options = {"payload": {"mass": start.payload.mass}, "gravity": start.gravity or "earth"}
        if "wearers" in terms:
            options["wearer"] = WEARERS[start.wearer]
            options["misalignment"] = tuple(start.misalignment.tolist())
        made = ArmEnv(coupling="cuffs", **options)
        made.reset(seed=seed)
        one, other = (go_on(env, 30, 0.1) for env in (drawn, made))
        for name in ("angle", "human_torque", "suit_torque", "cuff_force"):
            np.testing.assert_allclose(one[-1][name], other[-1][name], rtol=1e-7, atol=1e-7)
    assert len(met) > 1


def test_no_misalignment_in_the_range_loses_an_arm_at_once():
    # Newton's method threw the exoskeleton about from 0.03 m on.
    arms = ArmEnv(coupling="cuffs", randomize={"misalignment": 0.05}).rows(100)
    arms.reset(seed=0)
    for _ in range(3):
        *_, ended, _, _ = arms.step(np.zeros((100, 2)))
        assert not ended.any()


APART = {"spring": [0.5, 2.0], "loop": [0.4, 0.7, 2.5, 4.0]}


def drawn_suits(arms, seeds):
    """Returns factors of springs and loops, shape (seeds, 4) each."""
    found = []
    for first in range(0, seeds, arms.num_envs):
        _, info = arms.reset(seed=first)
        found.append((info["suit_spring"], info["suit_loop"]))
    return (np.concatenate(one) for one in zip(*found, strict=True))


def test_every_seed_draws_a_suit_of_its_own_in_the_ranges():
    arms = ArmEnv(randomize=APART).rows(50, info="full")
    spring, loop = drawn_suits(arms, 400)
    assert len({*map(tuple, np.hstack([spring, loop]).tolist())}) == 400
    assert (0.5 - 1e-12 <= spring).all() and (spring <= 2 + 1e-12).all()
    low = loop < 1
    assert (0.4 - 1e-12 <= loop[low]).all() and (loop[low] <= 0.7 + 1e-12).all()
    assert (2.5 - 1e-12 <= loop[~low]).all() and (loop[~low] <= 4 + 1e-12).all()
    assert (low.all(axis=1) | ~low.any(axis=1)).all()  # all joints of a suit are in one range
    assert 0.4 < low.mean() < 0.6
    common = np.median(np.log(spring), axis=1)
    for part in np.quantile(common, [0.25, 0.5, 0.75]), np.log([0.5**0.5, 1, 2**0.5]):
        np.testing.assert_allclose(part, [-0.35, 0.0, 0.35], atol=0.12)  # log-uniform
    inside = (spring.min(axis=1) > 0.6) & (spring.max(axis=1) < 1.7)
    spread = np.log(spring[inside]).std(axis=1, ddof=1)
    assert 0.12 < np.sqrt(np.mean(spread**2)) < 0.17
    assert abs(np.corrcoef(common, low.any(axis=1))[0, 1]) < 0.15  # each for itself


@pytest.mark.parametrize("suit", ["mock-suit", "emu-like"])
def test_drawn_suits_have_the_elastic_torque_and_the_loop_that_info_tells(suit):
    env = ArmEnv(suit=suit, randomize={**APART, "pressure": 0.5})
    own, shares = load_suit(suit).joints, []
    for seed in range(4):
        _, info = env.reset(seed=seed)
        for i, joint in enumerate(JOINTS):
            cycle, drawn = own[joint].steady_cycle(), env.episodes._start(0).suit[joint]
            found = drawn.steady_cycle()
            stiffness = info["suit_spring"][i] * cycle.spring()[1]
            assert found.spring()[1] == pytest.approx(stiffness, rel=1e-5)
            lost = info["suit_loop"][i] * cycle.dissipated
            assert found.dissipated == pytest.approx(lost, rel=1e-5)
            torque = -drawn.response([info["angle"][i]])[0]
            assert info["suit_torque"][i] == pytest.approx(torque, abs=1e-9)
        shares.append(
            info["suit_loop"] / ArmEnv(suit=suit, randomize=APART).reset(seed=seed)[1]["suit_loop"]
        )
    # Pressure is another factor: of the whole torque, or of the gas's share of the elastic torque.
    assert (np.ptp(shares, axis=0) > 0.1).all() == (suit == "mock-suit")


def test_drawn_suits_are_saved_copied_and_the_same_in_any_row():
    arms = ArmEnv(level="unseen").rows(6, info="full")
    arms.reset(seed=[3, 1, 4, 1, 5, 9])
    actions = np.random.default_rng(0).uniform(-0.3, 0.3, (60, 6, 2))
    for action in actions[:20]:
        arms.step(action)
    copies = [pickle.loads(pickle.dumps(arms)), ArmEnv(level="unseen").rows(6, info="full")]
    copies[1].set_state(arms.get_state())
    whole = reported(arms, actions[20:])
    for other in copies:
        found = reported(other, actions[20:])
        for name in ("angle", "suit_torque", "suit_spring", "suit_loop"):
            np.testing.assert_array_equal(found[name], whole[name])
    alone = ArmEnv(level="unseen")
    for row, seed in enumerate([3, 1, 4, 1, 5, 9]):
        alone.reset(seed=seed)
        found = reported(alone, actions[:, row])
        for name in ("angle", "suit_torque", "suit_spring", "suit_loop"):
            np.testing.assert_array_equal(found[name][20:], whole[name][:, row])


def wardrobe():
    """Suits whose models are of another kind, or are at fewer joints."""
    own = load_suit("mock-suit")
    play = PrandtlIshlinskii(stiffness=1.5, thresholds=(0.05, 0.2), weights=(6.0, 4.0))
    rest = {name: entry for name, entry in own.joints.items() if name != "elbow_flexion"}
    others = {name: entry.model_copy(update={"model": play}) for name, entry in own.joints.items()}
    made = {"none at the elbow": rest, "play": others}
    return {
        name: Suit(name=name, description="of a test", joints=joints)
        for name, joints in made.items()
    }


@pytest.mark.parametrize("other", wardrobe().values(), ids=wardrobe())
def test_suits_of_other_kinds_are_those_of_an_environment_made_with_them(other, tmp_path):
    other.save(tmp_path / "other.json")
    other = str(tmp_path / "other.json")
    drawn = ArmEnv(randomize={"suits": [other]})  # the compiled suit is mock-suit
    made = ArmEnv(suit=other)
    for env in (drawn, made):
        env.reset(seed=4)
    one, two = (reported(env, np.full((100, 2), 0.1)) for env in (drawn, made))
    for name in ("angle", "suit_torque", "dissipated_energy"):
        np.testing.assert_array_equal(one[name], two[name])


def test_rows_of_one_batch_wear_suits_of_other_kinds(tmp_path):
    suits = ["mock-suit", "emu-like"]
    for name, suit in wardrobe().items():
        suit.save(tmp_path / f"{name}.json")
        suits.append(str(tmp_path / f"{name}.json"))
    arms = ArmEnv(randomize={"suits": suits}).rows(16, info="full")
    arms.reset(seed=0)
    models = [arms.episodes._start(row).suit["shoulder_flexion"].model for row in range(16)]
    kinds = {Clipped, Asymmetric, PrandtlIshlinskii}  # Asymmetric: emu-like, with its gas
    assert {type(model) for model in models} == kinds
    info = go_on(arms, 20)[-1]
    without = ["elbow_flexion" not in arms.episodes._start(row).suit for row in range(16)]
    np.testing.assert_array_equal(info["suit_torque"][:, ELBOW] == 0, without)
    assert 0 < np.sum(without) < 16


def test_the_noise_of_sensors_may_differ():
    env = ArmEnv(coupling="cuffs", sensors=["cuffs"], randomize={"sensor_noise": [0.0, 3.0]})
    ratios = []
    for seed in range(6):
        env.reset(seed=seed)
        factor, errors = env.get_state()["noise_scale"][0], []
        for _ in range(60):
            shown, *_, info = env.step(np.zeros(2))
            errors.append(shown - info["cuff_force"].ravel())
        ratios.append(np.std(errors) / factor)
    np.testing.assert_allclose(ratios, 1.0, rtol=0.1)  # N, the usual noise of a cuff


def test_a_term_that_is_added_leaves_the_others_alone():
    few = ArmEnv(suit=SAMPLED, randomize={"suit": "samples"})
    many = ArmEnv(suit=SAMPLED, randomize={"suit": "samples", "encoder_offset": 0.1})
    for seed in range(6):
        few.reset(seed=seed)
        many.reset(seed=seed)
        one, other = few.get_state(), many.get_state()
        np.testing.assert_array_equal(one["angle"], other["angle"])
        np.testing.assert_array_equal(one["physics"], other["physics"])
        assert not np.array_equal(one["encoder_offset"], other["encoder_offset"])


def test_cycles_change_the_torque_of_a_suit_that_softens():
    softening = Softening(first=1.5, steady=0.8, cycles=2.0)
    torques = []
    for suit, terms in ((suit_of(softening=softening), {"cycles": [0, 4]}), (suit_of(), {})):
        _, info = ArmEnv(suit=suit, randomize=terms).rows(16, info="full").reset(seed=0)
        torques.append(info["suit_torque"][:, ELBOW])
    drawn = torques[0] / torques[1]
    assert 0.8 < drawn.min() < drawn.max() - 0.1 and drawn.max() < 1.52
    bound = MODEL.certificate().torque_bound
    for preconditioned, factor in ((False, 1.5), (True, 0.8)):  # its first cycle, or after many
        config = ArmConfig(suit=suit_of(softening=softening), preconditioned=preconditioned)
        model = suit_of_config(config).joints["elbow_flexion"].model
        assert model.certificate().torque_bound == pytest.approx(factor * bound)


def play(env, seed, periods=20):
    """Returns the states of two episodes after some control periods."""
    states = []
    for given in (seed, None):
        env.reset(seed=given)
        go_on(env, periods, 0.1)
        states.append(env.get_state())
    return states


def assert_same(states, others):
    for state, other in zip(states, others, strict=True):
        assert_same_states(state, other)


@pytest.mark.parametrize("level", LEVELS)
def test_a_level_is_its_options_and_the_same_seed_the_same_episodes(level):
    named = ArmEnv(coupling="cuffs", level=level)
    found = play(named, 4)
    assert_same(found, play(named, 4))  # another episode came before
    options = with_level({"coupling": "cuffs", "level": level})
    assert "level" not in options
    assert_same(found, play(ArmEnv(**options), 4))
    assert not np.array_equal(found[0]["physics"], play(named, 5)[0]["physics"])


def test_levels_differ_and_nominal_is_the_default():
    states = {level: play(ArmEnv(level=level), 1) for level in LEVELS}
    assert_same(states["nominal"], play(ArmEnv(), 1))
    one, other = (states[level][0]["physics"] for level in ("nominal", "randomized"))
    assert not np.array_equal(one, other)
    for level in LEVELS.keys() - {"nominal"}:  # the motion is the same at each
        np.testing.assert_array_equal(states["nominal"][0]["angle"], states[level][0]["angle"])


def test_unseen_suits_have_another_shape_the_same_size_and_other_persons():
    seen, unseen, beyond = (
        LEVELS[name]["randomize"] for name in ("randomized", "unseen", "beyond")
    )
    assert not any(person in seen["wearers"] for person in unseen["wearers"])
    assert unseen["wearers"] == beyond["wearers"]
    env = ArmEnv(level="unseen")
    assert env.config.suit == "mock-suit"  # which controllers believe
    mock, other = (load_suit(name).joints["elbow_flexion"] for name in ("mock-suit", "emu-like"))
    size = other.model.Ms / mock.model.Ms
    for name in ("spring", "loop"):
        np.testing.assert_allclose(np.multiply(unseen[name], size), seen[name], rtol=0.01)
        (_, low, high, _), inside = np.multiply(beyond[name], size), seen[name]
        np.testing.assert_allclose([low, high], inside, rtol=0.01)
    terms = seen.keys() - {"spring", "loop", "wearers"}
    assert {name: unseen[name] for name in terms} == {name: seen[name] for name in terms}


def test_options_that_are_given_win():
    shift = LEVELS["shift"]
    assert with_level({"level": "shift", "gravity": "moon"}) == {**shift, "gravity": "moon"}
    assert ArmEnv(level="shift", gravity="moon").config.gravity == "moon"
    rows = [({}, shift["pressure"]), ({"suit": "mock-suit"}, None)]  # the pressure is of the suit
    for given, pressure in [*rows, ({"suit": "emu-like", "pressure": 30.0}, 30.0)]:
        config = ArmEnv(level="shift", **given).config
        assert (config.suit, config.pressure) == (given.get("suit", shift["suit"]), pressure)


def test_terms_are_replaced_one_by_one():
    usual = {k: v for k, v in LEVELS["randomized"]["randomize"].items() if k != "misalignment"}
    own = {"pressure": 0.0, "gravity": ["moon", "mars"]}
    found = with_level({"level": "randomized", "randomize": own})["randomize"]
    assert found == {**usual, **own}
    env = ArmEnv(level="randomized", randomize=own)
    assert env.episodes.setup.randomize == Randomization(**usual | own)
    # A Randomization says all of its terms.
    whole = Randomization(load=0.1)
    found = with_level({"level": "randomized", "randomize": whole})["randomize"]
    assert Randomization(**found) == whole
    assert LEVELS["randomized"]["randomize"].keys() > usual.keys()  # nothing has changed there
    assert with_level({"level": "nominal", "randomize": own}) == {"randomize": own}


@pytest.mark.parametrize("level", LEVELS)
def test_what_a_level_says_of_what_is_not_there_does_not_count(level):
    for coupling, suit in product(("rigid", "cuffs", "none"), ("none", "mock-suit")):
        options = with_level({"level": level, "coupling": coupling, "suit": suit})
        terms = options.get("randomize", {})
        assert options["suit"] == suit
        if coupling != "cuffs":
            assert "misalignment" not in terms
        if suit == "none":
            assert not terms.keys() & {"pressure", "spring", "loop", "suits"}
            assert not options.keys() & {"pressure", "preconditioned"}
        ArmEnv(**options).reset(seed=0)  # no check refuses it


@pytest.mark.parametrize(
    ("level", "reference"),
    [("shift", "suited"), ("randomized", "suited"), ("randomized", "unsuited")],
)
def test_references_are_of_the_same_wearers_places_and_motions(level, reference):
    given = {"level": level, "coupling": "cuffs"}
    exo, other = ArmEnv(**given), ArmEnv(**reference_options(reference, given))
    assert not other.action_space.shape[0]
    assert (other.config.suit == "none") == (reference == "unsuited")
    for field in ("gravity", "wearer", "side", "tilt"):
        assert getattr(other.config, field) == getattr(exo.config, field)
    met = set()
    for seed in range(5):
        exo.reset(seed=seed)
        other.reset(seed=seed)
        one, two = exo.get_state(), other.get_state()
        for name in ("angle", "wearer", "load", "free_fall"):
            np.testing.assert_array_equal(one[name], two[name], name)
        met.add(int(one["wearer"][0]))
    assert (len(met) > 1) == (level == "randomized")
