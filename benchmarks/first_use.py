"""The time of a first use: an environment is made, reset and moved once, from an empty cache."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from typing import Any

from ..envs.simulation.compiling import ALONE
from ..errors import InputError

ENV = "ActiveSuit/ArmTracking-v0"
DEAREST = 10  # number of functions in the table


@dataclass(frozen=True, kw_only=True)
class FirstUse:
    """A first use.

    Attributes:
        processes: Number of processes that were allowed to compile.
        wall: Time until the first step was done [s].
        cpu: Processor time of all processes [s].
        compilations: Number of functions that the first process compiled, each specialization
            counted.
        dearest: Processor time of the functions that took longest to compile in the first process,
            without those that they call [s].
    """

    processes: int
    wall: float
    cpu: float
    compilations: int
    dearest: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def first_uses() -> list[FirstUse]:
    """Measures a first use by one process, and by as many as there usually are."""
    return [_measured(processes) for processes in (1, 2)]


def _measured(processes: int) -> FirstUse:
    with tempfile.TemporaryDirectory() as cache:
        own = {"NUMBA_CACHE_DIR": cache, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        if processes == 1:
            own[ALONE] = "1"
        begun, before = time.perf_counter(), _children()
        found = subprocess.run(
            [sys.executable, "-m", __name__],
            env={**os.environ, **own},
            capture_output=True,
            check=False,
            text=True,
        )
        wall, cpu = time.perf_counter() - begun, _children() - before
    if found.returncode:
        raise InputError(f"the first use failed, repair it first: {found.stderr.strip()[-300:]}")
    return FirstUse(processes=processes, wall=wall, cpu=cpu, **json.loads(found.stdout))


def _children() -> float:
    import resource  # not on Windows

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def tables(found: list[FirstUse]) -> dict[str, tuple[list[str], list[list[str]]]]:
    """Returns the tables of some first uses by title: header and rows."""
    times = [
        [str(one.processes), f"{one.wall:.1f} s", f"{one.cpu:.1f} s", str(one.compilations)]
        for one in found
    ]
    dearest = [[name, f"{seconds:.2f} s"] for name, seconds in found[0].dearest.items()]
    header = ["processes", "time", "processor time", "compilations\nof the first"]
    return {
        "first use, from an empty cache": (header, times),
        "the functions that took longest to compile": (["function", "processor time"], dearest),
    }


def _use() -> None:
    """Makes, resets and moves an environment, and prints what was compiled as JSON."""
    from numba.core import event

    class Costs(event.Listener):
        def __init__(self) -> None:
            self.own: dict[str, float] = {}
            self.count, self._open = 0, list[tuple[float, float]]()

        def on_start(self, event: Any) -> None:
            self._open.append((time.process_time(), 0.0))

        def on_end(self, event: Any) -> None:
            begun, inside = self._open.pop()
            spent = time.process_time() - begun
            function = event.data["dispatcher"].py_func
            name = f"{function.__module__.removeprefix('activesuit.')}.{function.__qualname__}"
            self.own[name] = self.own.get(name, 0.0) + spent - inside
            self.count += 1
            if self._open:
                self._open[-1] = (self._open[-1][0], self._open[-1][1] + spent)

    costs = Costs()
    event.register("numba:compile", costs)
    from ..envs.making import make_env

    env, _ = make_env(ENV)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    dearest = sorted(costs.own, key=lambda name: -costs.own[name])[:DEAREST]
    result = {"compilations": costs.count, "dearest": {name: costs.own[name] for name in dearest}}
    print(json.dumps(result))


if __name__ == "__main__":
    _use()
