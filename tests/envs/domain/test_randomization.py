"""What differs from episode to episode: drawn by seed, and each term for itself."""

import numpy as np
import pytest
from activesuit.assets import JOINTS, Softening, Suit, SuitJoint, load_suit
from activesuit.envs import ArmEnv
from activesuit.envs.model import ArmConfig, suit_of_config
from activesuit.hysteresis import Asymmetric, BoucWen, Clipped, PrandtlIshlinskii

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
    """A suit of one joint."""
    joints = {"elbow_flexion": ENTRY.model_copy(update=changes)}
    return Suit(name="s", description="of a test", joints=joints)


SAMPLED = suit_of(samples=SAMPLES)  # samples that cannot be mistaken for each other


@pytest.mark.parametrize("samples", [SAMPLES, KINDS], ids=["scaled", "kinds"])
def test_drawn_suits_appear_in_the_torque_of_their_rows(samples):
    arms = ArmEnv(
        suit=suit_of(samples=samples),
        sensors=["encoders", "privileged"],
        randomize={"suit": "samples"},
    ).rows(24, info="full")
    observation, info = arms.reset(seed=0)
    angles, torques = [info["angle"][:, ELBOW]], [info["suit_torque"][:, ELBOW]]
    shown = observation[:, arms.layout["suit_torque"]][:, ELBOW]
    np.testing.assert_allclose(shown, torques[0], rtol=1e-6)
    for _ in range(60):
        *_, info = arms.step(np.zeros((24, 2)))
        angles.append(info["angle"][:, ELBOW])
        torques.append(info["suit_torque"][:, ELBOW])
    drawn = set()
    for angle, torque in zip(np.array(angles).T, np.array(torques).T, strict=True):
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
        for _ in range(30):
            one, other = drawn.step(np.full(2, 0.1)), made.step(np.full(2, 0.1))
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


def wardrobe():
    """Suits whose models are of another kind, or are at fewer joints."""
    own = load_suit("mock-suit")
    play = PrandtlIshlinskii(stiffness=1.5, thresholds=(0.05, 0.2), weights=(6.0, 4.0))
    about = {"start_angle": 0.0, "grade": "assumed", "source": "of a test"}
    rest = {name: entry for name, entry in own.joints.items() if name != "elbow_flexion"}
    others = {
        name: SuitJoint.from_model(play, range=entry.range, **about)
        for name, entry in own.joints.items()
    }
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
    for _ in range(100):
        one, two = drawn.step(np.full(2, 0.1)), made.step(np.full(2, 0.1))
        for name in ("angle", "suit_torque", "dissipated_energy"):
            np.testing.assert_array_equal(one[-1][name], two[-1][name])


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
    for _ in range(20):
        *_, info = arms.step(np.zeros((16, 2)))
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
