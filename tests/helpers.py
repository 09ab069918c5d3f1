"""Published numbers and motions that several tests share."""

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import count, pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from activesuit.assets import Suit
from activesuit.envs.tasks import TASKS, Task
from activesuit.errors import InputError
from activesuit.hysteresis import HysteresisModel, PrandtlIshlinskii
from activesuit.hysteresis.engine import attach
from activesuit.identification import Curve
from activesuit.plots import Plot
from activesuit.published import LI_TABLE_2 as TABLE_2  # noqa: F401  (for the tests)
from activesuit.scripts.folders import RunFolder
from activesuit.scripts.main import main

NUMBERS = count()
BENCHMARK = (
    *("benchmark", "run", "--tasks", "ElbowFlexion", "--levels", "nominal", "--motions", "8"),
    *("--believed", "emu-like", "--workers", "1", "--backend", "threading"),
)
PATIENCE = 600  # [s], longest wait for another process or a server, far more than any takes


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Runs a command that succeeds; returns what it prints."""
    main([str(one) for one in arguments])
    return capsys.readouterr().out


def fails(
    capsys: pytest.CaptureFixture[str],
    *arguments: object,
    shown: bool = False,
    program: Callable[[list[str]], None] = main,
) -> str:
    """Runs a command that must end with exit code 2 and one sentence, which it returns.

    Before the sentence there may be lines about progress; nothing is printed unless `shown`.
    """
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        program([str(one) for one in arguments])
    captured = capsys.readouterr()
    assert stop.value.code == 2, arguments
    assert shown or captured.out == ""
    assert "Traceback" not in captured.out + captured.err
    message = captured.err.strip().splitlines()[-1]
    assert message.startswith("activesuit: "), message
    return message


def python(
    *arguments: object, check: bool = False, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Runs Python in a process of its own; returns what the process printed."""
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=check, **options)


def content(folder: Path) -> dict[Path, bytes | None]:
    """Returns everything in a folder: the bytes of files, None for folders."""
    paths = (path for path in folder.rglob("*"))
    return {
        path.relative_to(folder): path.read_bytes() if path.is_file() else None for path in paths
    }


def sweep(*turns: float, samples: int = 200) -> np.ndarray:
    """Angles that run through `turns` [rad], `samples` per branch."""
    branches = [np.linspace(start, end, samples)[1:] for start, end in pairwise(turns)]
    return np.concatenate([[turns[0]], *branches])


def peak(model: HysteresisModel) -> float:
    """Returns the largest torque [N·m] between 0.52 and 1.57 rad."""
    return np.abs(model.response(sweep(0.52, 1.57, 0.52))).max()


def prediction_error(
    model: HysteresisModel,
    known: HysteresisModel,
    turns: Iterable[float],
    *,
    begin: Any = 0.0,
    **options: Any,
) -> float:
    """Returns the error over the peak where a model begins with a torque, on other curves."""
    curves = family(known, turns, **options)
    errors = [model.response(curve.angle, begin) - curve.torque for curve in curves]
    return np.sqrt(np.mean(np.concatenate(errors) ** 2)) / peak(known)


def family(
    model: HysteresisModel,
    turns: Iterable[float] = (0.87, 1.22, 1.57),
    *,
    start: float = 0.52,
    first: float = 0.0,
    noise: float = 0.0,
    share: float = 0.0,
    seed: int = 0,
    samples: int = 60,
    role: str = "fit",
) -> list[Curve]:
    """First-order curves [rad] that begin with the torque `first`, with white noise.

    The noise is `noise` [N·m], or a `share` of the peak.
    """
    rng, curves = np.random.default_rng(seed), []
    noise = share * peak(model) if share else noise
    for turn in turns:
        angle = sweep(start, turn, start, samples=samples)
        torque = model.response(angle, first) + noise * rng.standard_normal(angle.size)
        curves.append(Curve(angle, torque, f"{turn}", role))
    return curves


def along(
    model: HysteresisModel,
    *turns: float,
    name: str = "A",
    first: float = 0.0,
    noise: float = 0.0,
    rng: int | np.random.Generator = 0,
    samples: int = 200,
    **fields: Any,
) -> Curve:
    """Returns the curve through `turns` [rad], with white noise [N·m]."""
    angle = sweep(*turns, samples=samples)
    errors = noise * np.random.default_rng(rng).standard_normal(angle.size)
    return Curve(angle, model.response(angle, first) + errors, name, **fields)


def spring(stiffness: float, rest_angle: float = 0.52) -> HysteresisModel:
    """Returns a model without memory, of that stiffness [N·m/rad]."""
    flat = {"thresholds": [1.0], "weights": [0.0]}
    return PrandtlIshlinskii(stiffness=stiffness, **flat, rest_angle=rest_angle)


def attached(xml: str, joint: str, model: HysteresisModel, **options: Any) -> mujoco.MjData:
    """Returns the first state of an MJCF model with hysteresis at a joint."""
    spec = mujoco.MjSpec.from_string(xml)
    attach(spec, joint, model, **options)
    return mujoco.MjData(spec.compile())


def is_safe(model: HysteresisModel, *angle_range: tuple[float, float]) -> bool:
    """Returns whether a model is certified and dissipative, in a range of angles or everywhere."""
    certificate = model.certificate(*angle_range)
    return certificate.certified and certificate.dissipative


def interrupt(*given: object, **options: object) -> None:
    """Does what Ctrl-C does, in place of any function."""
    raise KeyboardInterrupt


def set_all(patch: pytest.MonkeyPatch, owner: object, **values: object) -> None:
    """Gives attributes of a module or a class other values."""
    for name, value in values.items():
        patch.setattr(owner, name, value)


def assert_refused(call: Callable[..., object], rows: Iterable[tuple]) -> None:
    """Asserts that each row's arguments are refused with its last element, in one sentence."""
    for *given, message in rows:
        try:
            call(*given)
        except InputError as refusal:
            text = str(refusal)
            assert re.search(message, text), f"{given}: {text}"
            assert "\n" not in text and not text.endswith("."), text
        else:
            pytest.fail(f"{given} is accepted, and {message!r} was expected")


def without_volume_shares(suit: Suit) -> Suit:
    """Returns the suit with a torque, friction included, that is proportional to its pressure."""
    joints = {
        name: joint.model_copy(update={"volume_share": None}) for name, joint in suit.joints.items()
    }
    return suit.model_copy(update={"joints": joints})


def in_this_process(
    work: Callable[..., object], arguments: Iterable[tuple], *others: object
) -> Iterator[object]:
    """Does what `run_all` does, without processes that would import everything first."""
    return (work(*given) for given in arguments)


def shorten_tasks(
    patch: pytest.MonkeyPatch, duration: float, tasks: dict[str, Task] = TASKS
) -> None:
    """Makes the episodes of the shipped tasks, by their names, as long as that [s]."""
    for name, task in tasks.items():
        patch.setitem(tasks, name, replace(task, duration=duration))


def made_result(**changes: Any) -> Any:
    """Returns a result of the benchmark with two motions, or with changed fields."""
    from activesuit.envs.benchmark import Result

    usual = {"task": "Scoop", "level": "nominal", "believed": "mock-suit", "policy": "none"}
    usual |= {"options": {"name": "none"}, "effort": (0.1, 0.2), "tracking": (0.01, 0.02)}
    usual |= {"success": (True, False), "failed": None, "protocol": {"contract": "abc"}, **changes}
    return Result(**{"assisted_effort": usual["effort"], **usual})


@contextmanager
def short_benchmark(duration: float) -> Iterator[None]:
    """Makes the motions of the benchmark as long as that [s]."""
    from activesuit.envs.benchmark.suites import SUITE_TASKS

    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, duration)
        shorten_tasks(patch, duration, SUITE_TASKS)
        yield


@contextmanager
def without_figures() -> Iterator[None]:
    """Commands write another number for each figure: drawing takes most of their time."""

    def write_number(folder: RunFolder, name: str, figure: object) -> None:
        for suffix in (".png", ".svg"):
            folder.text(name + suffix, str(next(NUMBERS)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RunFolder, "figure", write_number)
        patch.setattr(Plot, "figure", lambda plot: plot)
        yield


def panels_of(folder: Path) -> list[dict[str, Any]]:
    """Returns data and layout of every panel of the page of a run."""
    page = (folder / "report.html").read_text(encoding="utf-8")
    found = re.findall(r'<script type="application/json">(.*?)</script>', page)
    return [json.loads(one) for one in found]
