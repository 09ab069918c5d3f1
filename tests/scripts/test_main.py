"""What all commands have in common: signals, MuJoCo's warnings, control characters, workers."""

import os
import re
import signal
import subprocess
import sys

import mujoco
import numpy as np
import pytest
from activesuit.assets import Suit, load_suit
from activesuit.scripts import main as main_module
from activesuit.scripts import output
from activesuit.scripts.engine_log import engine_warnings
from activesuit.scripts.main import main
from activesuit.scripts.output import progress, table
from activesuit.tables import markdown_table
from activesuit.text import visible
from helpers import PATIENCE, fails, python

SLOW = (
    "import sys, time\n"
    "from activesuit.scripts import output\n"
    "output.Bar.advance = lambda self, steps=1: (print('step', flush=True), time.sleep(0.2))\n"
    "from activesuit.scripts.main import main\n"
    "main(sys.argv[1:])\n"
)


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_with_a_sentence(tmp_path, sign):
    # A program in the background ignores Ctrl-C, and passes that on.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    command = [sys.executable, "-c", SLOW, "demo", "--trials", "9", "--out", tmp_path / "out"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, **pipes, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "step\n"
    process.send_signal(sign)
    _, message = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2
    assert "Traceback" not in message
    assert "interrupted: the finished fits (" in message.splitlines()[-1]


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
def test_an_interrupt_that_became_another_exception_is_one(monkeypatch, capsys, sign):
    # As in the loading of a compiled module: "ImportError: initialization failed".
    def load(arguments):
        try:
            signal.raise_signal(sign)
        except KeyboardInterrupt as interrupt:
            raise ImportError("initialization failed") from interrupt

    monkeypatch.setattr(main_module, "_run", load)
    with pytest.raises(SystemExit) as stop:
        main([])
    assert stop.value.code == 2
    assert capsys.readouterr().err == "activesuit: interrupted\n"


def test_an_interrupt_inside_a_text_that_a_library_runs_has_exit_code_2(tmp_path):
    (tmp_path / "interrupted.py").write_text(
        "from activesuit.scripts import main\n"
        "main._run = lambda arguments: exec('raise KeyboardInterrupt')\n"
        "main.main([])\n"
    )
    end = python("-m", "interrupted", cwd=tmp_path)
    assert (end.returncode, end.stderr) == (2, "activesuit: interrupted\n")


def test_other_exceptions_pass(monkeypatch):
    def fail(arguments):
        raise ImportError("initialization failed")

    monkeypatch.setattr(main_module, "_run", fail)
    with pytest.raises(ImportError):
        main([])


def test_afterwards_sigterm_means_what_it_did_before():
    before = signal.getsignal(signal.SIGTERM)
    main(["--version"])
    assert signal.getsignal(signal.SIGTERM) is before


def unstable():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint type='slide'/><geom size='1'/></body></worldbody></mujoco>"
    )
    for _ in range(3):
        data = mujoco.MjData(model)
        data.qpos[0] = np.nan
        mujoco.mj_step(model, data)


def test_warnings_of_mujoco_are_printed_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with engine_warnings():
        unstable()
    assert list(tmp_path.iterdir()) == []
    (message,) = capsys.readouterr().err.splitlines()
    assert message.startswith("activesuit: warning of MuJoCo (3 times): Nan, Inf or huge value in")
    assert mujoco.get_mju_user_warning() is None


def test_ctrl_c_while_mujoco_warns_does_not_end_the_process():
    # A handler written in Python would raise KeyboardInterrupt inside MuJoCo, which aborts.
    with engine_warnings():
        assert type(mujoco.get_mju_user_warning()).__name__ == "builtin_function_or_method"


ESCAPE = "\x1b[31mred\x9b2J\u202e\r\udc80"
SHOWN = r"\x1b[31mred\x9b2J\u202e\r\udc80"


def test_control_characters_are_visible():
    assert visible(ESCAPE) == SHOWN
    assert visible(visible(ESCAPE)) == SHOWN
    assert visible("Ellbogen, 5 N·m\n日本") == "Ellbogen, 5 N·m\n日本"


def test_tables_and_bars_escape_names(capsys):
    table(ESCAPE, ["a", ESCAPE], [[ESCAPE, "1"]])
    with progress(f"{ESCAPE} [/x]", 1) as bar:
        bar.advance()
    captured = capsys.readouterr()
    assert "\x1b" not in captured.out + captured.err
    assert captured.out.count("\\x1b[31mred") >= 2
    assert "\x1b" not in markdown_table(["a"], [[ESCAPE]])


def test_a_log_has_a_line_for_a_tenth_of_the_way(capsys, monkeypatch):
    clock = iter([0.0, 100.0, 110.0, 120.0, 130.0, 140.0])
    monkeypatch.setattr(output.time, "monotonic", lambda: next(clock))
    with progress("work", 5) as bar:
        for _ in range(5):
            bar.advance()
    lines = [f"work: {20 * i} % after {90 + 10 * i} s" for i in range(1, 6)]
    assert capsys.readouterr().err.splitlines() == lines


def test_no_table_is_cut(capsys, monkeypatch):
    names = [f"my_policies:PDSuit:kp=5,kd={i}" for i in range(2)]
    header = ["policy", *(f"relief, 95 % interval {i}" for i in range(8))]
    rows = [[name, *(f"0.{i} of a long cell in one line" for i in range(8))] for name in names]
    table("A title" + 30 * " and more", ["a"], [["1"]])
    assert capsys.readouterr().out.startswith("A title" + 30 * " and more" + "\n")
    table("A title", header, rows)
    lines = capsys.readouterr().out.splitlines()
    for row in rows:
        (line,) = [line for line in lines if row[0] in line]
        assert all(cell in line for cell in row)
    for columns in ("80", "160"):
        monkeypatch.setenv("COLUMNS", columns)
        monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
        table("A title", header, rows)
        shown = capsys.readouterr().out
        assert "…" not in shown
        shown = re.sub(r"\x1b\[[0-9;]*m|[ \n─━]", "", shown)
        cells = ["A title", *header, *(cell for row in rows for cell in row)]
        assert sorted(shown) == sorted("".join(cells).replace(" ", ""))


def test_names_of_a_suit_and_in_messages_are_escaped(capsys, tmp_path):
    joints = {"elbow_flexion": load_suit("mock-suit").joints["elbow_flexion"]}
    names = {"name": "a\x1b[31m", "description": "b\x1b]0;title\x07"}
    Suit(**names, joints=joints).save(tmp_path / "s.json")
    main(["list", "suits", str(tmp_path / "s.json")])
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    assert "\\x1b[31m" in shown
    message = fails(capsys, "list", "suits", "x\x1b[2J\ny")
    assert "\x1b" not in message
    assert os.linesep not in message
