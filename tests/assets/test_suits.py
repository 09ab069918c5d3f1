import hashlib
import json

import pytest
from activesuit.assets import (
    CURVES,
    JOINTS,
    Suit,
    SuitJoint,
    curves_path,
    load_suit,
    save_suit,
    suit_names,
)
from activesuit.errors import InputError
from activesuit.hysteresis import (
    Asymmetric,
    BoucWen,
    Held,
    JilesAtherton,
    PrandtlIshlinskii,
    Preisach,
)
from helpers import TABLE_2

SAFE = JilesAtherton(Ms=11.4488, a=128.97, alpha=-0.0515, c=6.4043, k=23.0945, angle_unit="deg")
UNSAFE = JilesAtherton(Ms=22.2316, a=319.55, alpha=6.3223, c=4.7447, k=168.582, angle_unit="deg")
KINDS = [
    SAFE,
    JilesAtherton(Ms=10, a=2, alpha=0.01, c=0.5, k=1, allow_active=True, clamp="jiles"),
    Held(model=SAFE, angle_range=(0.4, 1.2)),
    Asymmetric(model=Held(model=SAFE, angle_range=(0.4, 1.2)), polynomial=[0.1, 2.0]),
    BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=0.5),
    PrandtlIshlinskii(stiffness=-1, thresholds=[0.1, 0.4], weights=[-2, -3], operator="play"),
    Preisach(levels=[0.1, 0.7, 1.5], density=[[0.2], [0.1, 0.3]], elastic=[1.0, 2.0]),
]


@pytest.fixture
def content():
    return json.loads(load_suit("mock-suit").model_dump_json())


def load(folder, content):
    path = folder / "suit.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return load_suit(path)


def test_shipped_suits():
    assert suit_names() == ["mock-suit", "published-2022"]
    for name in suit_names():
        suit = load_suit(name)
        assert suit.name == name
        assert tuple(sorted(suit.joints)) == tuple(sorted(JOINTS))
    for entry in load_suit("mock-suit").joints.values():
        assert entry.model.certificate().certified
        assert entry.model.certificate().dissipative


def test_published_suit_is_table_2_as_printed():
    suit = load_suit("published-2022")
    for name, joint in CURVES.items():
        model = suit.joints[joint].model
        printed = TABLE_2[f"{name}-sa-pso"]
        assert (model.Ms, model.a, model.alpha, model.c, model.k) == printed
        assert model.angle_unit == "deg"


def test_provenance_names_the_curves_it_came_from():
    suit = load_suit("mock-suit")
    for name, joint in CURVES.items():
        entry = suit.joints[joint]
        assert entry.grade == "identified"
        assert "SYNTHETIC" in entry.source
        assert entry.data_sha256 == hashlib.sha256(curves_path(name).read_bytes()).hexdigest()
    for joint in set(JOINTS) - set(CURVES.values()):
        assert suit.joints[joint].grade == "assumed"


def test_round_trip(tmp_path):
    suit = load_suit("mock-suit")
    save_suit(suit, tmp_path / "copy.json")
    assert load_suit(tmp_path / "copy.json") == suit


@pytest.mark.parametrize("model", KINDS, ids=lambda model: model.name)
def test_every_model_can_be_in_a_suit(tmp_path, model):
    joint = SuitJoint(
        model=model,
        samples=(model, model.scaled(torque=1.1)),
        range=(0.0, 1.0),
        start_angle=0.5,
        start_torque=0.2,
        grade="assumed",
        source="nowhere",
    )
    suit = Suit(name="any", description="", joints={"wrist_flexion": joint})
    save_suit(suit, tmp_path / "any.json")
    again = load_suit(tmp_path / "any.json")
    assert again == suit
    assert again.joints["wrist_flexion"].model == model
    assert again.joints["wrist_flexion"].samples[1] == model.scaled(torque=1.1)


def test_samples_are_as_safe_as_the_model(tmp_path, content):
    entry = content["joints"]["elbow_flexion"]
    entry["samples"] = [SAFE.to_dict(), UNSAFE.to_dict()]
    message = r"elbow_flexion: samples\[1\] has certificate margin -0.2.* but the model .*remove"
    with pytest.raises(InputError, match=message):
        load(tmp_path, content)
    entry["model"] = UNSAFE.to_dict()
    assert load(tmp_path, content).joints["elbow_flexion"].samples == (SAFE, UNSAFE)


def changed(content, path, value):
    *parents, last = path
    inner = content
    for key in parents:
        inner = inner[key]
    inner[last] = value
    return content


ELBOW = ("joints", "elbow_flexion")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("colour",), "white", "colour is not a known field"),
        (
            ("schema_version",),
            1,
            "schema_version is 1, .*reads 2: remake it with `activesuit i",
        ),
        (("joints", "knee"), {}, "joints.knee is 'knee': use .*'elbow_flexion'"),
        (
            (*ELBOW, "model"),
            "preisach",
            "elbow_flexion.model: a model is described by a dict",
        ),
        ((*ELBOW, "model", "model"), "preisac", "elbow_flexion.model: unknown model .*'preisach'"),
        ((*ELBOW, "model", "Ms"), -1, "elbow_flexion.model: parameter Ms is -1.0: .*above 0"),
        ((*ELBOW, "model", "k"), "x", "elbow_flexion.model: parameter k is 'x': give a number"),
        ((*ELBOW, "model", "kk"), 1, "elbow_flexion.model: .*unexpected keyword argument 'kk'"),
        ((*ELBOW, "samples"), [{}], r"elbow_flexion.samples.0: unknown model 'None'"),
        ((*ELBOW, "start_torque"), "x", "elbow_flexion.start_torque: .*number.*'x'"),
        ((*ELBOW, "range"), [1.0, 0.5], "range is .*smaller one"),
        ((*ELBOW, "grade"), "guess", "grade is 'guess'"),
        ((*ELBOW, "range"), [30, 90], "more than a full turn; both are radians"),
    ],
)
def test_bad_content(tmp_path, content, path, value, message):
    with pytest.raises(InputError, match=message) as error:
        load(tmp_path, changed(content, path, value))
    assert "suit.json" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_missing_field_is_named(tmp_path, content):
    entry = content["joints"]["elbow_flexion"]
    k = entry["model"].pop("k")
    with pytest.raises(InputError, match=r"elbow_flexion\.model: .* missing .* argument: 'k'$"):
        load(tmp_path, content)
    entry["model"]["k"] = k
    del entry["range"]
    with pytest.raises(InputError, match=r"elbow_flexion\.range is missing: add it$"):
        load(tmp_path, content)


def test_bad_files(tmp_path, content):
    with pytest.raises(InputError, match=r"not complete JSON \(line"):
        load(tmp_path, json.dumps(content, indent=1)[:300])
    with pytest.raises(InputError, match="schema_version is None"):
        load(tmp_path, "[1, 2]")
    with pytest.raises(InputError, match="No such file"):
        load_suit(tmp_path / "none.json")
    with pytest.raises(InputError, match=r"unknown suit 'mocksuit'.*did you mean 'mock-suit'"):
        load_suit("mocksuit")
