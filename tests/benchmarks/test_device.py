"""The benchmark of C code: every example is within its tolerance, and a compiler is needed."""

import json

import pytest
from activesuit.benchmarks import device
from activesuit.benchmarks.__main__ import main
from activesuit.benchmarks.references import EXAMPLES
from c_programs import need_compiler
from helpers import fails

pytestmark = pytest.mark.slow


def test_c_code_of_all_examples(capsys):
    need_compiler()
    main(["device", "--json"])
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [row["model"] for row in rows] == [e.name for one in EXAMPLES.values() for e in one]
    for row in rows:
        assert row["double"]["difference"] < 1e-12
        assert 0 < row["float"]["difference"] < 5e-5
        assert row["constants"] > row["state"] / 2 > 0


def test_without_a_compiler(capsys, monkeypatch):
    monkeypatch.setattr(device, "compiler", lambda: None)
    message = fails(capsys, "device", program=main)
    assert "there is no C compiler: install cc, gcc or clang" in message
