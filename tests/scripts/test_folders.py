"""Run folders: a command replaces what it wrote itself, and nothing else without --force."""

import subprocess
import sys
from pathlib import Path

import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.files import scratch_prefix
from activesuit.scripts.folders import RunFolder, close_folders
from activesuit.scripts.main import main
from helpers import content, fails

ELBOW = str(curves_path("elbow"))
WRITERS = {
    "identify": ["identify", ELBOW, "--joint", "elbow_flexion"],
    "rig": ["measure", "rig"],
    "demo": ["demo", "--trials", "1", "--episodes", "8"],
    "evaluate": ["evaluate", "--episodes", "8"],
    "simulate": ["simulate"],
    "validate": ["validate", "mock-suit", "--plant", "mock-suit"],
    "train": ["train", "--steps", "1"],
}


@pytest.fixture(autouse=True)
def closed():
    yield
    close_folders()


@pytest.mark.slow
@pytest.mark.parametrize("command", WRITERS)
def test_a_folder_of_something_else_or_another_command_is_refused(capsys, tmp_path, command):
    if command == "train":
        pytest.importorskip("stable_baselines3")
    foreign, other = tmp_path / "foreign", tmp_path / "other"
    foreign.mkdir()
    (foreign / "config.json").write_text("{}")
    RunFolder(other, "measure").json("config.json", {})
    close_folders()
    before = content(tmp_path)
    message = fails(capsys, *WRITERS[command], "--out", foreign)
    assert "(config.json)" in message
    assert "--force" in message
    message = fails(capsys, *WRITERS[command], "--out", other)
    assert f"holds a run of measure, not of {command}" in message
    assert content(tmp_path) == before


@pytest.mark.slow
def test_a_second_run_replaces_its_own_files_only(tmp_path, capsys):
    main(["measure", "rig", "--out", str(tmp_path)])
    first = content(tmp_path)
    main(["measure", "rig", "--noise", "0.5", "--out", str(tmp_path)])
    assert content(tmp_path).keys() == first.keys()
    assert content(tmp_path) != first
    (tmp_path / "wrist_flexion.csv").write_text("measured")
    capsys.readouterr()
    before = content(tmp_path)
    arguments = ["measure", "rig", "--joint", "wrist_flexion", "--out", tmp_path]
    assert "was not written by this command" in fails(capsys, *arguments)
    assert content(tmp_path) == before  # all of the first run, nothing of the second
    main([*map(str, arguments), "--force"])
    assert (tmp_path / "wrist_flexion.csv").read_text() != "measured"


def test_force_takes_a_folder_over(tmp_path):
    (tmp_path / ".DS_Store").touch()
    RunFolder(tmp_path, "rig").text("a.txt", "")  # hidden files do not fill a folder
    close_folders()
    (tmp_path / ".activesuit").unlink()
    (tmp_path / "notes.txt").write_text("mine")
    RunFolder(tmp_path, "rig", force=True).text("a.txt", "")
    close_folders()
    RunFolder(tmp_path, "rig").text("a.txt", "")
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_no_link_is_followed(tmp_path):
    outside, out = tmp_path / "outside", tmp_path / "out"
    outside.mkdir()
    (outside / "a.txt").write_text("precious")
    out.symlink_to(outside)
    with pytest.raises(InputError, match="is a link"):
        RunFolder(out, "rig", force=True)
    out.unlink()
    RunFolder(out, "rig").text("a.txt", "ours")
    (out / "a.txt").unlink()
    (out / "a.txt").symlink_to(outside / "a.txt")
    (out / "trials").symlink_to(outside)
    folder = RunFolder(out, "rig", force=True)
    for write in (lambda: folder.text("a.txt", ""), lambda: folder.subfolder("trials")):
        with pytest.raises(InputError, match="is a link"):
            write()
    assert content(outside) == {outside.joinpath("a.txt").relative_to(outside): b"precious"}


def test_a_record_that_is_a_link_is_refused(tmp_path):
    outside = tmp_path / "outside"
    outside.write_text("precious")
    out = tmp_path / "out"
    out.mkdir()
    (out / ".activesuit").symlink_to(outside)
    with pytest.raises(InputError, match="choose another --out"):
        RunFolder(out, "rig", force=True)
    assert outside.read_text() == "precious"


def test_another_process_in_the_folder_is_reported(tmp_path):
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from activesuit.scripts.folders import RunFolder\n"
        "folder = RunFolder(Path(sys.argv[1]), 'rig')\n"
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
        RunFolder(tmp_path, "rig", force=True)
    other.kill()
    other.communicate()
    RunFolder(tmp_path, "rig").text("a.txt", "")  # the lock ended with the process


def test_a_path_that_is_none():
    with pytest.raises(InputError, match="cannot make the folder"):
        RunFolder(Path("a\0b"), "demo")


def test_a_mistake_leaves_nothing(capsys, tmp_path):
    out = tmp_path / "new" / "out"
    fails(capsys, "identify", ELBOW, "--trials", "0", "--out", out)
    assert list(tmp_path.iterdir()) == []
    tmp_path.joinpath("empty").mkdir()
    fails(capsys, "identify", ELBOW, "--trials", "0", "--out", tmp_path / "empty")
    assert list(tmp_path.rglob("*")) == [tmp_path / "empty"]


def test_files_move_in_together_or_not_at_all(tmp_path):
    folder = RunFolder(tmp_path, "rig")
    folder.text("a.txt", "old")
    with pytest.raises(RuntimeError), folder.together() as new:
        new.text("a.txt", "new")
        raise RuntimeError
    (tmp_path / "b.txt").write_text("mine")
    with pytest.raises(InputError, match=r"b\.txt"), folder.together() as new:
        new.text("a.txt", "new")
        new.text("b.txt", "new")
    assert (tmp_path / "a.txt").read_text() == "old"
    with pytest.raises(KeyboardInterrupt), folder.together("kept") as new:
        new.text("a.txt", "new")
        raise KeyboardInterrupt
    assert (tmp_path / "a.txt").read_text() == "old"
    assert (tmp_path / "kept" / "a.txt").read_text() == "new"
    with folder.together() as new:
        new.text("a.txt", "new")
    assert (tmp_path / "a.txt").read_text() == "new"
    assert not list(tmp_path.glob(".activesuit-*"))


def test_scratch_of_a_killed_run_goes_with_the_next(tmp_path):
    folder = RunFolder(tmp_path, "benchmark")
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    prefix, _, _ = scratch_prefix().rpartition(f"{folder_process()}-")
    left = [
        tmp_path / f"{prefix}{dead.pid}-12345678.json",
        folder.subfolder("trials") / f"{prefix}{dead.pid}-12345678.json",
    ]
    for path in left:
        path.touch()
    (tmp_path / f"{prefix}{dead.pid}-abcdefgh").mkdir()
    close_folders()
    RunFolder(tmp_path, "benchmark").subfolder("trials")
    assert {path.name for path in tmp_path.rglob("*")} == {".activesuit", "trials"}


def folder_process() -> str:
    return scratch_prefix().rstrip("-").rpartition("-")[2]
