import hashlib
import json

import pytest
from activesuit.assets import CURVES, JOINTS, curves_path, load_suit, save_suit, suit_names
from activesuit.envs.composition import joint_models
from activesuit.errors import InputError
from helpers import TABLE_2


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
    for model in joint_models(load_suit("mock-suit")).values():
        assert model.certificate().certified
        assert model.certificate().dissipative


def test_published_suit_is_table_2_as_printed():
    models = joint_models(load_suit("published-2022"))
    for name, joint in CURVES.items():
        model = models[joint]
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
        (("schema_version",), 2, "schema_version is 2; this release reads version 1"),
        (("joints", "knee"), {}, "joints.knee is 'knee': use .*'elbow_flexion'"),
        ((*ELBOW, "model"), "preisach", "elbow_flexion.model is 'preisach': use 'jiles-atherton'"),
        ((*ELBOW, "parameters", "Ms"), -1, "parameters.Ms: .*greater than 0.*-1"),
        ((*ELBOW, "parameters", "k"), "x", "parameters.k: .*number.*'x'"),
        ((*ELBOW, "parameters", "kk"), 1, "parameters.kk is not a known field"),
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
    del content["joints"]["elbow_flexion"]["parameters"]["k"]
    with pytest.raises(InputError, match=r"elbow_flexion\.parameters\.k is missing: add it$"):
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
