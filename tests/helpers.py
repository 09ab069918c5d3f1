"""Published numbers and motions that several tests share."""

import json
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import count, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from activesuit.assets import Suit
from activesuit.envs.tasks import TASKS, Task
from activesuit.errors import InputError
from activesuit.hysteresis import HysteresisModel, PrandtlIshlinskii
from activesuit.identification import Curve
from activesuit.plots import Plot
from activesuit.published import LI_TABLE_2 as TABLE_2  # noqa: F401  (for the tests)
from activesuit.scripts.folders import RunFolder
from activesuit.scripts.main import main

NUMBERS = count()
PATIENCE = 600  # [s], longest wait for another process or a server, far more than any takes


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """Runs a command that succeeds; returns what it prints."""
    main([str(one) for one in arguments])
    return capsys.readouterr().out


def fails(capsys: pytest.CaptureFixture[str], *arguments: object, shown: bool = False) -> str:
    """Runs a command that must end with exit code 2 and one sentence, which it returns.

    Before the sentence there may be lines about progress; nothing is printed unless `shown`.
    """
    capsys.readouterr()
    with pytest.raises(SystemExit) as stop:
        main([str(one) for one in arguments])
    captured = capsys.readouterr()
    assert stop.value.code == 2, arguments
    assert shown or captured.out == ""
    assert "Traceback" not in captured.out + captured.err
    message = captured.err.strip().splitlines()[-1]
    assert message.startswith("activesuit: "), message
    return message


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


def family(
    model: HysteresisModel,
    turns: Iterable[float] = (0.87, 1.22, 1.57),
    *,
    start: float = 0.52,
    first: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
    samples: int = 60,
    role: str = "fit",
) -> list[Curve]:
    """First-order curves [rad] that begin with the torque `first`, with white noise [N·m]."""
    rng = np.random.default_rng(seed)
    curves = []
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
    return PrandtlIshlinskii(
        stiffness=stiffness, thresholds=[1.0], weights=[0.0], rest_angle=rest_angle
    )


def one_sentence(refusal: pytest.ExceptionInfo) -> bool:
    """Returns whether an error is one sentence, without a full stop at its end."""
    text = str(refusal.value)
    return "\n" not in text and len(text) <= 400 and not text.endswith(".")


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
