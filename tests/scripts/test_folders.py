"""Run folders: new, empty, or with --force; and one command at a time."""

import subprocess
import sys
from pathlib import Path

import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.files import scratch_prefix
from activesuit.scripts.folders import RunFolder, close_folders
from helpers import content, fails

ELBOW = str(curves_path("elbow"))
WRITERS = {
    "identify": ["identify", ELBOW, "--joint", "elbow_flexion"],
    "rig": ["rig"],
    "demo": ["demo", "--trials", "1", "--motions", "8"],
    "evaluate": ["evaluate", "--motions", "8"],
    "simulate": ["simulate"],
    "validate": ["validate", "mock-suit", "--plant", "mock-suit"],
    "benchmark": ["benchmark", "run"],
    "train": ["train", "--steps", "1"],
}


@pytest.fixture(autouse=True)
def closed():
    yield
    close_folders()


@pytest.mark.slow
@pytest.mark.parametrize("command", WRITERS)
def test_a_folder_that_holds_files_is_refused(capsys, tmp_path, command):
    if command == "train":
        pytest.importorskip("stable_baselines3")
    (tmp_path / "config.json").write_text("{}")
    message = fails(capsys, *WRITERS[command], "--out", tmp_path)
    assert "(config.json)" in message
    assert "--force" in message
    assert content(tmp_path) == {Path("config.json"): b"{}"}


def test_hidden_files_force_and_what_goes_on(tmp_path):
    (tmp_path / ".DS_Store").touch()
    RunFolder(tmp_path).text("a.txt", "old")  # hidden files do not fill a folder
    for given in ({"force": True}, {"resumes": True}):
        close_folders()
        with pytest.raises(InputError, match=r"holds files \(a\.txt\)"):
            RunFolder(tmp_path)
        RunFolder(tmp_path, **given).text("a.txt", str(given))
        assert (tmp_path / "a.txt").read_text() == str(given)


def test_no_link_is_followed(tmp_path):
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    (outside / "a.txt").write_text("precious")
    out.symlink_to(outside)
    with pytest.raises(InputError, match="is a link"):
        RunFolder(out, force=True)
    out.unlink()
    folder = RunFolder(out)
    (out / "a.txt").symlink_to(outside / "a.txt")
    (out / "trials").symlink_to(outside)
    for write in (lambda: folder.text("a.txt", ""), lambda: folder.subfolder("trials")):
        with pytest.raises(InputError, match="is a link"):
            write()
    assert content(outside) == {outside.joinpath("a.txt").relative_to(outside): b"precious"}


def test_another_process_in_the_folder_is_reported(tmp_path):
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from activesuit.scripts.folders import RunFolder\n"
        "folder = RunFolder(Path(sys.argv[1]))\n"
        "print('ready', flush=True)\n"
        "sys.stdin.read()\n"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert other.stdout is not None
    assert other.stdout.readline() == "ready\n"
    with pytest.raises(InputError, match="another command writes into"):
        RunFolder(tmp_path, force=True)
    other.kill()
    other.communicate()
    RunFolder(tmp_path).text("a.txt", "")  # the lock ended with the process


def test_a_path_that_is_none():
    with pytest.raises(InputError, match="cannot make the folder"):
        RunFolder(Path("a\0b"))


def test_a_mistake_leaves_nothing(capsys, tmp_path):
    out = tmp_path / "new" / "out"
    fails(capsys, "identify", ELBOW, "--trials", "0", "--out", out)
    assert list(tmp_path.iterdir()) == []
    tmp_path.joinpath("empty").mkdir()
    fails(capsys, "identify", ELBOW, "--trials", "0", "--out", tmp_path / "empty")
    assert list(tmp_path.rglob("*")) == [tmp_path / "empty"]


def test_scratch_of_a_killed_run_goes_with_the_next_file(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    prefix, _, _ = scratch_prefix().rstrip("-").rpartition("-")
    (tmp_path / f"{prefix}-{dead.pid}-12345678.json").touch()
    RunFolder(tmp_path).text("a.txt", "")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
