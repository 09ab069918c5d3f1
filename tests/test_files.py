"""Files are written in one piece, over regular files only, and nothing is left behind."""

import os
import stat

import pytest
from activesuit.errors import InputError
from activesuit.files import SCRATCH, check_target, replacing, write_text
from helpers import python


def test_a_file_is_replaced_when_the_block_succeeds(tmp_path):
    path = tmp_path / "a.txt"
    with replacing(path) as scratch:
        scratch.write_text("new")
        assert not path.exists()
    assert path.read_text() == "new"
    with pytest.raises(RuntimeError), replacing(path) as scratch:
        scratch.write_text("half")
        raise RuntimeError
    assert path.read_text() == "new"
    assert [one.name for one in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_permissions_are_kept(tmp_path, mode):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(mode)
    write_text(path, "new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_a_new_file_has_the_permissions_of_any_new_file(tmp_path):
    with pytest.raises(InputError, match="choose a folder that exists"):
        write_text(tmp_path / "none" / "a.txt", "")
    write_text(tmp_path / "a", "")
    (tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_without_force_a_file_stays(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(InputError, match=r"exists: .* --force"), replacing(path, force=False):
        pytest.fail("the work was done for nothing")
    assert path.read_text() == "old"


def test_a_file_that_appears_meanwhile_stays(tmp_path):
    path = tmp_path / "a.txt"
    with pytest.raises(InputError, match="exists"), replacing(path, force=False):
        path.write_text("another's")
    assert path.read_text() == "another's"
    assert not [*tmp_path.glob(".*")]


@pytest.mark.parametrize("force", [True, False])
def test_only_regular_files_are_replaced(tmp_path, force):
    outside = tmp_path / "outside.txt"
    outside.write_text("precious")
    (tmp_path / "link").symlink_to(outside)
    (tmp_path / "broken").symlink_to(tmp_path / "nowhere")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    before = {path.name: path.lstat().st_mode for path in tmp_path.iterdir()}
    reasons = {"link": "is a link", "broken": "is a link", "folder": "is a folder"}
    for name, reason in (reasons | {"pipe": "is not a regular file"}).items():
        with pytest.raises(InputError, match=reason), replacing(tmp_path / name, force=force):
            pytest.fail("the work was done for nothing")
    with pytest.raises(InputError, match="is not a regular file"):
        check_target(tmp_path.__class__("/dev/null"), force=force)
    assert {path.name: path.lstat().st_mode for path in tmp_path.iterdir()} == before
    assert outside.read_text() == "precious"


def test_a_killed_process_leaves_no_half_file(tmp_path):
    code = (
        "import os, signal, sys\n"
        "from activesuit.files import replacing\n"
        "with replacing(sys.argv[1]) as scratch:\n"
        "    scratch.write_text('half')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    python("-c", code, tmp_path / "a.txt")
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(SCRATCH)
