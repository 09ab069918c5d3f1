"""`activesuit doctor`: a line for each check, with the mend where something fails."""

import json
import os
from contextlib import nullcontext
from importlib import metadata

import pytest
from activesuit.assets import curves_path
from activesuit.envs.simulation.compiling import ALONE
from activesuit.errors import InputError
from activesuit.hysteresis import first_use
from activesuit.scripts import compiling
from activesuit.scripts.commands import doctor as module
from activesuit.scripts.main import main
from helpers import python
from numba import njit

PICTURE = module.PICTURE


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    """Draws nothing, since a picture takes seconds."""
    monkeypatch.setattr(module, "PICTURE", "print('drawn')")


def replace_versions(monkeypatch, **given):
    """Gives packages other versions, or None to those that are not installed."""
    real = metadata.version

    def version(name):
        found = given[name] if name in given else real(name)
        if found is None:
            raise metadata.PackageNotFoundError(name)
        return found

    monkeypatch.setattr(module.metadata, "version", version)


def shown(capsys, code=0):
    with pytest.raises(SystemExit) if code else nullcontext() as caught:
        main(["doctor"])
    assert not code or caught.value.code == code
    captured = capsys.readouterr()
    lines = [" ".join(line.split()) for line in captured.out.splitlines()]
    return lines, captured.err


def test_a_sound_installation_has_a_line_for_each_part(capsys):
    lines, error = shown(capsys)
    assert not error
    for name in ("python", "mujoco", "numpy", "numba", "kernel cache", "MuJoCo plugins", "OpenGL"):
        assert any(line.startswith(f"ok {name}: ") for line in lines), name
    assert any("extra train" in line for line in lines)
    assert not any("extra dev" in line for line in lines)
    main(["doctor", "--json"])
    found = json.loads(capsys.readouterr().out)
    python = next(one for one in found["checks"] if one["name"] == "python")
    assert found["ok"] and python["ok"] and python["needed"] and python["mend"] == ""


def test_an_old_and_a_missing_package_fail_with_their_mend(monkeypatch, capsys):
    replace_versions(monkeypatch, rich=None, numba="0.50.0", onnx=None)
    lines, error = shown(capsys, code=2)
    assert "FAILS numba: 0.50.0; run pip install 'numba>=0.61'" in lines
    assert "FAILS rich: not installed; run pip install 'rich>=13'" in lines
    assert error == "activesuit: error: numba, rich must be mended: each line above says how\n"
    install = "pip install -e '.[onnx]' -c constraints.txt"  # as in docs/install.md
    assert f"- extra onnx: lacks onnx; run {install} in the clone to use it" in lines


def test_a_package_that_is_not_installed(monkeypatch, capsys):
    def gone(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(module.metadata, "metadata", gone)
    lines, _ = shown(capsys, code=2)
    assert lines == ["FAILS activesuit: not installed; run pip install ."]


def test_a_cache_that_cannot_be_used(monkeypatch, capsys):
    def refused():
        raise InputError("other users may write: choose a folder of your own")

    monkeypatch.setattr(first_use, "check_cache", refused)
    lines, _ = shown(capsys, code=2)
    (line,) = [line for line in lines if line.startswith("FAILS")]
    assert line.startswith("FAILS kernel cache: cannot be used; other users may write")


def test_a_backend_that_does_not_draw(monkeypatch, capsys):
    program = "import os; print('drawn' if os.environ.get('MUJOCO_GL') == 'egl' else 'black')"
    monkeypatch.setattr(module, "PICTURE", program)
    monkeypatch.setattr(module, "BACKENDS", {module.sys.platform: ("egl", "osmesa")})
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    lines, _ = shown(capsys)
    line = next(line for line in lines if "OpenGL" in line)
    assert line == "- OpenGL: does not draw off-screen (MUJOCO_GL=osmesa); set MUJOCO_GL=egl"
    monkeypatch.setattr(module, "PICTURE", "raise SystemExit(1)")
    lines, _ = shown(capsys)
    assert any("on Linux run apt install libegl1" in line for line in lines)


@pytest.mark.render
def test_a_picture_is_drawn(monkeypatch, capsys):
    monkeypatch.setattr(module, "PICTURE", PICTURE)
    monkeypatch.setattr(module, "BACKENDS", {})
    lines, _ = shown(capsys)
    assert any(line.startswith("ok OpenGL: draws off-screen") for line in lines)


def test_it_counts_what_it_compiles(capsys, monkeypatch):
    @njit
    def twice(x):
        return 2 * x

    monkeypatch.setenv(ALONE, "1")
    for name in ("_plugins", "_arms", "_models"):
        monkeypatch.setattr(compiling, name, lambda: None)
    monkeypatch.setattr(compiling, "_fit", lambda: twice(1.0))
    for count in ("1", "none"):
        main(["doctor", "--compile"])
        assert f"kernels: all are compiled, {count} of them now\n" in capsys.readouterr().out


@pytest.mark.slow
def test_after_it_no_command_compiles_for_long(tmp_path):
    def run(*arguments):
        given = {"env": {**os.environ, ALONE: "1"}, "cwd": tmp_path}
        found = python("-m", "activesuit.scripts.main", *arguments, **given)
        assert "Traceback" not in found.stderr
        return found

    run("doctor", "--compile")
    assert "all are compiled, none of them now" in run("doctor", "--compile").stdout
    for command in (
        "simulate --out s",
        "evaluate --motions 8 --task ElbowFlexion --unadapted",
        f"identify {curves_path('elbow')} --joint elbow_flexion",
    ):
        assert "kernels" not in run(*command.split()).stderr
