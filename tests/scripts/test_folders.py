"""Run folders: new, empty, or with --force; one process at a time."""

import subprocess
import sys
from pathlib import Path

import pytest
from activesuit.errors import InputError
from activesuit.files import SCRATCH
from activesuit.scripts.folders import RunFolder, close_folders
from helpers import content

pytestmark = pytest.mark.usefixtures("closed")


def test_force_writes_beside_what_is_there(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(InputError, match="choose a new folder"):
        RunFolder(tmp_path)
    RunFolder(tmp_path, force=True).text("a.txt", "new")
    assert content(tmp_path) == {Path("notes.txt"): b"mine", Path("a.txt"): b"new"}


def test_a_run_that_goes_on_finds_its_folder(tmp_path):
    RunFolder(tmp_path).json("config.json", {})
    close_folders()
    RunFolder(tmp_path, resumes=True).text("a.txt", "more")
    assert {path.name for path in content(tmp_path)} == {"config.json", "a.txt"}


def test_a_command_without_a_folder_gets_a_new_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("rig", "rig-2", "rig-3"):
        folder = RunFolder.of(None, "rig")
        assert folder.path == Path("runs", name)
        folder.text("a.txt", "")


def test_what_a_killed_run_left_does_not_fill_a_folder(tmp_path):
    (tmp_path / f"{SCRATCH}12345678.json").touch()
    RunFolder(tmp_path).text("a.txt", "")


def test_no_link_is_followed(tmp_path):
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    (outside / "a.txt").write_text("precious")
    out.symlink_to(outside)
    with pytest.raises(InputError, match="is a link"):
        RunFolder(out, force=True)
    out.unlink()
    RunFolder(out).text("a.txt", "ours")
    close_folders()
    (out / "a.txt").unlink()
    (out / "a.txt").symlink_to(outside / "a.txt")
    (out / "trials").symlink_to(outside)
    folder = RunFolder(out, force=True)
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
    given = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    other = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], **given)
    assert other.stdout is not None
    assert other.stdout.readline() == "ready\n"
    with pytest.raises(InputError, match="another process writes into"):
        RunFolder(tmp_path, force=True)
    other.kill()
    other.communicate()
    RunFolder(tmp_path).text("a.txt", "")  # the lock ended with the process


def test_a_path_that_is_none():
    with pytest.raises(InputError, match="cannot make the folder"):
        RunFolder(Path("a\0b"))
