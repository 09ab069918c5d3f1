import hashlib
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit import hysteresis
from activesuit.assets import (
    CURVES,
    JOINTS,
    Softening,
    Suit,
    SuitJoint,
    curves_path,
    load_suit,
    suit_names,
)
from activesuit.benchmarks.references import EXAMPLES
from activesuit.hysteresis import Backlash, JilesAtherton, Viscoelastic
from activesuit.identification import Curve, fit_curves, load_curves
from helpers import TABLE_2, assert_refused, sweep, without_volume_shares

SAFE, UNSAFE = hysteresis.TABLE_2["elbow-sa-pso"], hysteresis.TABLE_2["shoulder-sa-pso"]
# Elastic torque is added behind the play, and so is not that of the joint's own angle.
KINDS = [one.model for name in EXAMPLES if name != "backlash" for one in EXAMPLES[name]]


def read_mock_suit():
    return json.loads(load_suit("mock-suit").model_dump_json())


def load(folder, content):
    path = folder / "suit.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return load_suit(path)


def joint_of(model, **changes):
    usual = {"range": (0.2, 1.2), "start_angle": 0.5, "grade": "assumed", "source": "a test"}
    usual["start_torque"] = model.response([0.0, 0.5])[-1]
    return SuitJoint(model=model, **(usual | changes))


def suit_of(joint, kpa=30):
    return Suit(name="any", description="Mine.", pressure_kpa=kpa, joints={"wrist_flexion": joint})


def at(kpa, joint, own=30):
    return suit_of(joint, own).at_pressure(kpa).joints.get("wrist_flexion")


def test_shipped_suits():
    assert suit_names() == ["emu-like", "exploration-56kpa", "mock-suit", "published-2022"]
    for name in suit_names():
        suit = load_suit(name)
        assert suit.name == name
        assert suit.label
        assert tuple(sorted(suit.joints)) == tuple(sorted(JOINTS))
        for entry in suit.joints.values():
            certificate = entry.model.certificate()
            assert certificate.margin == pytest.approx(entry.certificate_margin)
            assert name == "published-2022" or (certificate.certified and certificate.dissipative)


def test_emu_like_has_the_torque_of_its_sources():
    suit, mock = load_suit("emu-like"), load_suit("mock-suit")
    assert (suit.label, suit.pressure_kpa) == ("illustrative", 29.6)  # 4.3 psi
    elbow, wrist = (suit.joints[f"{joint}_flexion"] for joint in ("elbow", "wrist"))
    # Holschuh 2010: up to 20 N·m at 105 degrees, measured from 25 degrees on.
    for start in (elbow.start_angle, np.radians(25)):
        assert 15 < elbow.model.response([start, np.radians(105)])[-1] < 20
    assert wrist.model.response([0, np.radians(40)])[-1] == pytest.approx(3, abs=1e-6)
    angle = sweep(0.35, 1.22, 0.35, 1.22)
    ratio = elbow.model.Ms / mock.joints["elbow_flexion"].model.Ms
    ours, theirs = (one.joints["shoulder_flexion"].model.response(angle) for one in (suit, mock))
    assert np.abs(ours / ratio - theirs).max() < 0.05 * theirs.max()


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("name", ["emu-like", "exploration-56kpa"])
def test_the_torque_goes_on_rising_where_the_arm_can_bend_to(name, joint):
    entry = load_suit(name).joints[joint]
    low, high = entry.range
    rising = entry.model.response(sweep(entry.start_angle, low, high))[-199:]
    assert (np.diff(rising) > 0).all()


def test_exploration_is_emu_like_at_its_pressure():
    emu, exploration = load_suit("emu-like"), load_suit("exploration-56kpa")
    assert (exploration.label, exploration.pressure_kpa) == ("extrapolated", 56.5)
    assert exploration.joints == emu.at_pressure(56.5).joints


def test_joints_are_table_2_as_printed_or_name_their_curves():
    published, mock = (load_suit(name).joints for name in ("published-2022", "mock-suit"))
    for name, joint in CURVES.items():
        model, entry = published[joint].model, mock[joint]
        printed = TABLE_2[f"{name}-sa-pso"]
        assert (model.Ms, model.a, model.alpha, model.c, model.k) == printed
        assert model.angle_unit == "deg"
        assert entry.grade == "identified"
        assert "SYNTHETIC" in entry.source
        assert entry.data_sha256 == hashlib.sha256(curves_path(name).read_bytes()).hexdigest()
    assert {mock[joint].grade for joint in set(JOINTS) - set(CURVES.values())} == {"assumed"}


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_every_model_can_be_in_a_suit(tmp_path, model):
    suit = suit_of(joint_of(model, samples=(model, model.scaled(torque=1.1))))
    for one in (suit, suit.preconditioned()):
        one.save(tmp_path / "any.json")
        assert load_suit(tmp_path / "any.json") == one
    assert suit != one


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_torque_is_exactly_proportional_to_pressure(model):
    joint = joint_of(model, samples=(model, model))
    other = suit_of(joint).at_pressure(45)
    angle, scaled = sweep(0.5, 1.2, 0.4, 1.0), other.joints["wrist_flexion"]
    expected = 1.5 * model.response(angle, joint.start_torque)
    for one in (scaled.model, *scaled.samples):
        torque = one.response(angle, scaled.start_torque)
        np.testing.assert_allclose(torque, expected, rtol=1e-6, atol=1e-8)
    before, after = model.certificate(), scaled.model.certificate()
    assert after.margin == before.margin or after.margin == pytest.approx(before.margin, abs=1e-9)
    assert after.dissipative == before.dissipative
    assert scaled.source == "a test; then 1.5 times that torque"
    assert (other.label, other.pressure_kpa) == ("extrapolated", 45)
    assert "at 45 kPa: 1.5 times its torque at 30 kPa. Mine." in other.description


def test_pressures_at_the_border():
    suit = load_suit("emu-like")
    assert suit.at_pressure(29.6) is suit
    joint, empty = (one.joints["elbow_flexion"] for one in (suit, suit.at_pressure(0)))
    # friction remains where the gas has a share
    assert 0 < abs(empty.response([0.6, 1.2])[-1]) < abs(joint.response([0.6, 1.2])[-1])
    assert without_volume_shares(suit).at_pressure(0).joints == {}
    wrong = [(suit, one, f"pressure is {one} kPa: give 0 to 110 kPa") for one in (-1, 111)]
    wrong += [
        (suit, math.nan, "pressure is nan kPa: give 0 to 110 kPa"),
        (load_suit("mock-suit"), 40, r"suit 'mock-suit' does not tell at .* leave"),
    ]
    assert_refused(lambda one, pressure: one.at_pressure(pressure), wrong)
    assert_refused(joint.at_pressure_ratio, [(-1, "ratio is -1: give a ratio of pressures, 0 or")])


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_a_preconditioned_joint_begins_in_its_steady_cycle(model):
    joint = joint_of(model)
    used = joint.preconditioned()
    assert used.begun().angle == used.start_angle
    cycle = sweep(0.5, 1.2, 0.2, 0.5)
    for one, is_steady in ((used, True), (joint, False)):
        first, second = one.response(np.tile(cycle, 2)).reshape(2, -1)
        same = np.abs(second - first).max() <= 1e-5 * np.ptp(second)
        assert same == is_steady
    lowest, highest = joint.range
    before = [0.5, *(lowest, highest) * joint.steady_cycle().cycles, lowest]
    expected = model.response([*before, *cycle], joint.start_torque)[len(before) :]
    np.testing.assert_array_equal(used.response(cycle), expected)
    assert used.begun().torque == expected[0]


def test_all_samples_of_a_preconditioned_joint_are_steady():
    slow = JilesAtherton(Ms=10, a=2, alpha=0.01, c=1.2, k=4.0)
    joint = joint_of(SAFE, samples=(slow,))
    fast, slow_ones = (joint.steady_cycle(one).cycles for one in (SAFE, slow))
    assert fast != slow_ones
    used = joint.preconditioned()
    assert len(used.start_path) == 2 * max(fast, slow_ones) + 2
    cycle = np.tile(sweep(0.5, 1.2, 0.2, 0.5), 2)
    for model in (SAFE, slow):
        first, second = used.response(cycle, model).reshape(2, -1)
        assert np.abs(second - first).max() <= 1e-5 * np.ptp(second)


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_a_volume_share_changes_the_elastic_torque_alone(model):
    joint = joint_of(model, volume_share=0.7, samples=(model,))
    angle = np.linspace(0.2, 1.2, 201)
    cycle, own = sweep(0.5, 1.2, 0.2, 1.0), joint.response(sweep(0.5, 1.2, 0.2, 1.0))
    offset, stiffness = joint.steady_cycle().spring()
    for kpa in (0, 15, 45):
        other = at(kpa, joint)
        added = 0.7 * (kpa / 30 - 1) * (offset + stiffness * cycle)
        np.testing.assert_allclose(other.response(cycle), own + added, atol=1e-9)
        sampled = other.response(cycle, other.samples[0]) - joint.response(cycle, joint.samples[0])
        np.testing.assert_allclose(sampled, added, atol=1e-9)
        before, after = model.certificate(), other.model.certificate()
        assert (after.margin, after.dissipative) == (before.margin, before.dissipative)
        loop, kept = joint.steady_cycle(), other.steady_cycle()
        assert kept.dissipated == pytest.approx(loop.dissipated, rel=1e-5)
    line = offset + stiffness * angle
    pushed = [at(kpa, joint).response(angle)[line > 0] for kpa in (0, 10, 30, 60, 110)]
    assert (np.diff(pushed, axis=0) > 0).all()


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_elastic_torque_and_loop_are_scaled_apart(model):
    joint = joint_of(model, samples=(model,))
    cycle = sweep(0.5, 1.2, 0.2, 1.0)
    own, steady = joint.response(cycle), joint.steady_cycle()
    offset, stiffness = steady.spring()
    line = offset + stiffness * cycle
    for spring, loop in ((0.4, 2.5), (2.5, 0.4), (1.3, 1.3)):
        drawn = joint.apart(spring, loop)
        np.testing.assert_allclose(
            drawn.response(cycle), spring * line + loop * (own - line), atol=1e-9
        )
        np.testing.assert_array_equal(
            drawn.response(cycle, drawn.samples[0]), drawn.response(cycle)
        )
        found = drawn.steady_cycle()
        assert found.spring() == pytest.approx([spring * offset, spring * stiffness], rel=1e-6)
        assert found.dissipated == pytest.approx(loop * steady.dissipated, rel=1e-5)
        before, after = model.certificate(), drawn.model.certificate()
        assert (after.certified, after.dissipative) == (before.certified, before.dissipative)


def test_pressures_add_up_and_leave_the_structure():
    joint = joint_of(SAFE, volume_share=0.7)
    cycle = sweep(0.5, 1.2, 0.2, 1.0)
    once, twice = at(60, joint), at(60, at(40, joint), 40)
    np.testing.assert_allclose(twice.response(cycle), once.response(cycle), atol=1e-9)
    assert twice.volume_share == pytest.approx(once.volume_share) == pytest.approx(1.4 / 1.7)
    structure = at(0, joint)
    assert structure.volume_share == 0
    assert structure.steady_cycle().spring() == pytest.approx(
        [0.3 * number for number in joint.steady_cycle().spring()], abs=1e-6
    )
    np.testing.assert_array_equal(at(90, structure).response(cycle), structure.response(cycle))
    assert at(0, joint_of(SAFE)) is None
    alone = at(60, joint_of(SAFE, volume_share=0.0))
    assert alone.response(cycle) == pytest.approx(joint.response(cycle))
    assert "then 2 times the pressure, which changes 0.7 of the elastic torque" in once.source
    assert suit_of(joint).at_pressure(60).description == (
        "any at 60 kPa: extrapolated from 30 kPa by the volume_share of its joints. Mine."
    )


def test_bad_content(tmp_path):
    elbow = ("joints", "elbow_flexion")
    unsafe = [SAFE.to_dict(), UNSAFE.to_dict()]
    rows = [
        (("colour",), "white", "colour is not a known field"),
        (("schema_version",), 1, "schema_version is 1, .*reads 2: remake it with `activesuit i"),
        *((("schema_version",), one, "is .* reads 2") for one in (2.0, True, "2", [2], 10**300)),
        (("joints", "knee"), {}, "joints.knee is 'knee': use .*'elbow_flexion'"),
        ((*elbow, "model"), "preisach", "elbow_flexion.model: a model is described by a dict"),
        ((*elbow, "model"), {"model": "jiles-atherton"}, r"suit\.json.*\.model: .* has no Ms"),
        ((*elbow, "model", "model"), "preisac", "elbow_flexion.model: unknown model .*'preisach'"),
        ((*elbow, "model", "Ms"), -1, "elbow_flexion.model: Ms is -1.0 N·m: .*above 0"),
        ((*elbow, "model", "k"), "x", "elbow_flexion.model: k is 'x': give a number"),
        ((*elbow, "model", "kk"), 1, "unknown parameter of 'jiles-atherton' 'kk': use one of"),
        ((*elbow, "samples"), [{}], r"elbow_flexion.samples.0: unknown model 'None'"),
        ((*elbow, "samples"), unsafe, r"samples\[1\] has certificate margin -0.2.* but the .*remo"),
        ((*elbow, "start_torque"), "x", "elbow_flexion.start_torque: .*number.*'x'"),
        ((*elbow, "range"), [1.0, 0.5], "range is .*smaller one"),
        ((*elbow, "range"), [30, 90], "more than a full turn; both are radians"),
        ((*elbow, "range"), None, r"elbow_flexion\.range is missing: add it$"),
        ((*elbow, "grade"), "guess", "grade is 'guess'"),
        ((*elbow, "start_path"), [0.5, 30], r"start_path\[1\] is 30.*: more than a full turn"),
        ((*elbow, "volume_share"), 70, "volume_share is 70: give the share .*, 0 to 1, or leave"),
        ((*elbow, "softening", "first"), -1, r"softening\.first"),
        ((*elbow, "softening", "first"), 120, r"first: .* less than or equal to 10 \(it is 120\)"),
        ((*elbow, "softening", "first"), 9.2, "first is 9.2 and steady 0.9"),
        ((*elbow, "softening", "first"), "1.2", "give a number, without quotes, not '1.2'"),
        (("pressure_kpa",), 0, "pressure_kpa: it is 0: give kPa above 0, at most 110, or leave"),
        (("pressure_kpa",), 29600, "pressure_kpa: it is 29600: give kPa"),
        (("label",), "real", "label is 'real': use 'from paper', 'illustrative' or 'extrapol"),
    ]

    def read(path, value):
        content = read_mock_suit()
        content["joints"]["elbow_flexion"]["softening"] = {"first": 1.2, "steady": 0.9, "cycles": 5}
        *parents, last = path
        inner = content
        for key in parents:
            inner = inner[key]
        inner[last] = value
        if value is None:
            del inner[last]
        load(tmp_path, content)

    assert_refused(read, rows)
    content = read_mock_suit()
    content["joints"]["elbow_flexion"] |= {"samples": unsafe, "model": UNSAFE.to_dict()}
    assert load(tmp_path, content).joints["elbow_flexion"].samples == (SAFE, UNSAFE)


def test_bad_files(tmp_path):
    rows = [("{", r"not complete JSON \(line"), ("[1, 2]", "schema_version is None")]
    assert_refused(lambda text: load(tmp_path, text), rows)


@pytest.fixture(scope="module")
def fit():
    return fit_curves(load_curves(curves_path("elbow")))


def test_suits_from_fits(fit, tmp_path):
    base, model = load_suit("mock-suit"), fit.model
    fits = {"wrist_flexion": fit, "elbow_flexion": replace(fit, initial_torque=0.2)}
    samples = {"wrist_flexion": [model.scaled(torque=1.1)]}
    suit = Suit.from_fits(fits, name="mine", base=base, samples=samples)
    suit.save(tmp_path / "mine.json")
    assert load_suit(tmp_path / "mine.json") == suit
    assert suit.description.startswith("Identified: wrist_flexion from elbow.csv by certified; elb")
    wrist, elbow = suit.joints["wrist_flexion"], suit.joints["elbow_flexion"]
    digest = hashlib.sha256(curves_path("elbow").read_bytes()).hexdigest()
    expected = {
        "source": "certified fit of elbow.csv, curves 0.87, 1.22, 1.57.",
        "grade": "identified",
        "data_sha256": digest,
        "fit_nrmse": fit.nrmse,
        "range": (0.52, 1.57),
        "start_angle": 0.52,
        "start_torque": fit.initial_torque,
        "certificate_margin": model.certificate().margin,
        "samples": (model.scaled(torque=1.1),),
    }
    assert {name: getattr(wrist, name) for name in expected} == expected
    assert (elbow.samples, elbow.start_torque) == ((), 0.2)
    assert suit.joints["shoulder_flexion"] == base.joints["shoulder_flexion"]
    assert set(Suit.from_fits(fits).joints) == set(fits)


def test_a_suit_begins_where_curves_without_a_file_do(small_family):
    loaded = [Curve(c.angle, c.torque + 0.4, c.name, c.role) for c in small_family]
    entry = SuitJoint.from_fit(fit_curves(loaded, initial_torque="measured"))
    assert entry.source == "certified fit, curves 0.87, 1.22, 1.57."
    assert entry.data_sha256 is None
    assert entry.start_torque == np.mean([c.torque[0] for c in loaded if c.role == "fit"])


def test_bad_fits(fit):
    fits = {"elbow_flexion": fit}
    rows = [
        ({}, {}, r"fits is \{\}: give fits by joint, as \{'elbow_flexion': fit\}"),
        (fit, {}, "fits is .*: give fits by joint"),
        ({"knee": fit}, {}, "unknown joint 'knee': use one of elbow_flexion"),
        ({"elbow_flexio": fit}, {}, "did you mean 'elbow_flexion'"),
        ({"elbow_flexion": SAFE}, {}, "fit is JilesAtherton.*: give the fit of identify"),
        (fits, {"name": ""}, "name: String should have at least 1"),
        (fits, {"samples": {"wrist_flexion": []}}, "has 'wrist_flexion', which has no fit: leave"),
        (fits, {"samples": {"elbow_flexion": [UNSAFE]}}, "margin -0.2.* remove that sample"),
    ]
    assert_refused(lambda fits, options: Suit.from_fits(fits, **options), rows)


def test_suits_as_objects(tmp_path):
    suit = load_suit("mock-suit")
    joint = suit.joints["elbow_flexion"]
    assert load_suit(suit) is suit
    assert load_suit(suit.model_dump()) == suit
    assert hash(load_suit(suit.model_dump())) == hash(suit)
    assert load_suit({"elbow_flexion": joint}).joints == {"elbow_flexion": joint}
    rows = [
        (SAFE, "suit is JilesAtherton.*: give the name of a shipped suit, the path"),
        (None, "suit is None: give the name"),
        ({}, "suit: schema_version is None, and this release reads 2"),
        ("", "unknown suit ''"),
        ("mocksuit", r"unknown suit 'mocksuit'.*did you mean 'mock-suit'"),
        ("a\0b", r"unknown suit 'a\\x00b'"),
        ("x" * 5000, "unknown suit 'xxx.*: use one of"),
        (tmp_path / "none.json", "No such file"),
        (joint, r"give it by the name of its joint, as {'elbow_flexion':"),
        ({"knee": joint}, r"suit: joints.knee is 'knee': use"),
    ]
    assert_refused(load_suit, rows)
    others = joint.model_dump(exclude={"model", "certificate_margin"})
    rows = [
        (Backlash(model=joint.model, gap=3.0), "gap is 3 rad: give less than the range"),
        (Viscoelastic(model=joint.model, damping=1e12), r"damping is 1e\+12 N·m·s/rad"),
    ]
    assert_refused(lambda model: SuitJoint.from_model(model, **others), rows)


def test_a_joint_softens_over_its_cycles(tmp_path):
    still = load_suit("mock-suit").joints["elbow_flexion"]
    change = Softening(first=1.2, steady=0.9, cycles=5.0)
    joint, angle = still.model_copy(update={"softening": change}), np.linspace(*still.range)
    torque = joint.response(angle)
    for cycles in (0, 3, np.inf):
        factor = 0.9 + 0.3 * np.exp(-cycles / 5)
        later = joint.after(cycles)
        np.testing.assert_allclose(later.response(angle), factor * torque, rtol=1e-9)
        assert later.model.certificate().certified
        np.testing.assert_allclose(  # counts from when the joint was new
            later.after(8).response(angle), joint.after(8).response(angle), rtol=1e-9
        )
    assert "after 3 cycles" in joint.after(3).source
    assert still.after(100) is still
    suit = suit_of(joint)
    suit.save(tmp_path / "s.json")
    assert load_suit(tmp_path / "s.json").joints["wrist_flexion"].softening == change
    assert_refused(suit.after, [(-1, "cycles is -1")])
