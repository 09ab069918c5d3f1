"""JSON files of users: any mistake in one is reported in one sentence."""

from activesuit.json_files import read_json
from helpers import assert_refused


def read(folder, content):
    path = folder / "file.json"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_json(path, "suit")


def test_what_is_read(tmp_path):
    found = read(tmp_path, '{"a": [1, 2.5, null, "x"], "b": {"a": 1}}')
    assert found == {"a": [1, 2.5, None, "x"], "b": {"a": 1}}
    assert read(tmp_path, b'\xef\xbb\xbf{"a": 1}') == {"a": 1}
    assert read(tmp_path, "[" * 50 + "]" * 50)


def test_what_is_refused(tmp_path):
    rows = [
        ("", r"file\.json is not complete JSON \(line 1: Expecting value\): restore"),
        ('{"a": 1', r"is not complete JSON \(line 1"),
        ("[" * 10_000 + "]" * 10_000, "has more than 50 lists or objects inside each other"),
        ("[" * 100_000, "has more than 50 lists or objects inside each other"),
        ("[" * 52 + "]" * 52, "has more than 50 lists or objects inside each other"),
        ('{"a": ' * 10_000 + "1" + "}" * 10_000, "has more than 50 lists or objects"),
        ("9" * 5000, "has a number of 5,000 digits: give at most 400"),
        ('{"a": 1, "b": 2, "a": 1}', "has 'a' twice in one object: remove one of them"),
        ('{"x": [{"k": 1, "k": 2}]}', "has 'k' twice in one object"),
        (b"\xff\xfe{\x00", r"cannot read the suit '.*file\.json': not a UTF-8 text file"),
    ]
    assert_refused(lambda content: read(tmp_path, content), rows)


def test_files_that_cannot_be_read(tmp_path):
    rows = [
        (tmp_path / "none.json", "cannot read the suit .*: No such file"),
        (tmp_path, "cannot read the suit .*: Is a directory"),
        ("a\0b", "cannot read the suit .*: embedded null byte"),
        ("/dev/zero", "is longer than 64 MiB"),
    ]
    assert_refused(lambda path: read_json(path, "suit"), rows)
