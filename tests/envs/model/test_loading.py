"""Models from files, with the plugins of this package."""

import os
import subprocess
import sys
from pathlib import Path

import activesuit
import mujoco
import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs.model import ArmConfig, compose, load_model
from activesuit.hysteresis.engine import attach
from arms import posed
from helpers import assert_refused

JOINT = """<mujoco><worldbody><body><joint name="j" axis="0 1 0"/><geom size=".1"/></body>
  </worldbody></mujoco>"""
ROOT = Path(activesuit.__file__).parent.parent


def spec():
    made = mujoco.MjSpec.from_string(JOINT)
    attach(made, "j", load_suit("mock-suit").joints["elbow_flexion"].model)
    return made


@pytest.fixture
def files(tmp_path):
    (made := spec()).compile()
    (tmp_path / "one.xml").write_text(made.to_xml())
    mujoco.mj_saveModel(made.compile(), str(tmp_path / "one.MJB"), None)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("name", ["one.xml", "one.MJB"])
def test_a_process_that_imports_nothing_else_loads_a_model(files, name):
    program = (
        "import mujoco, sys; from activesuit.envs.model import load_model; "
        "data = mujoco.MjData(load_model(sys.argv[1])); "
        "data.qpos[0] = 0.4; mujoco.mj_forward(data.model, data); print(data.qfrc_passive[0])"
    )
    found = subprocess.run(
        [sys.executable, "-c", program, str(files / name)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=False,
        text=True,
        cwd=files,
    )
    assert found.returncode == 0, found.stderr
    data = posed(spec().compile(), 0.4)
    assert float(found.stdout) == data.qfrc_passive[0] < 0


def test_an_arm_on_cuffs_loads(tmp_path):
    model = compose(ArmConfig(coupling="cuffs"), drawn=False)
    mujoco.mj_saveModel(model, str(tmp_path / "arm.mjb"), None)
    loaded = load_model(tmp_path / "arm.mjb")
    np.testing.assert_array_equal(loaded.plugin, model.plugin)
    assert mujoco.MjData(loaded).plugin_state.size == model.npluginstate > 0


def test_files_that_are_no_model_get_one_sentence(files):
    (files / "bad.xml").write_text("<mujoco><worldbody><body></mujoco>")
    (files / "text.mjb").write_text("<mujoco/>" * 500)
    (files / "folder.xml").mkdir()
    content = (files / "one.MJB").read_bytes()
    cut = r"cannot load '.*cut.mjb' \(.*\): repair the file, or"
    for end in (0, 21, len(content) // 2, -1):
        (files / "cut.mjb").write_bytes(content[:end])
        assert_refused(load_model, [(files / "cut.mjb", cut)])
    rows = [
        (files / "bad.xml", "MuJoCo .* cannot load .*bad.xml.*XML"),
        (files / "text.mjb", "MuJoCo .* cannot load .*text.mjb"),
        (files / "folder.xml", "there is no file .*folder.xml': give the path of a model"),
        (files / "none.mjb", "there is no file .*none.mjb': give the path of a model"),
        (files / "arm.urdf", r"arm.urdf' is no .xml and no .mjb file: give one of these"),
        (3, r"the model is 3: give the path of a .xml or .mjb file"),
    ]
    assert_refused(load_model, rows)
