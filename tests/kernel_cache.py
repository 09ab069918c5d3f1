"""Compiled kernels for all processes of a test run: of today's sources, and compiled once."""

import ast
import os
import shutil
import subprocess
import sys
import time
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from activesuit.hysteresis import HysteresisModel

ROOT = Path(__file__).parent.parent
STORE = ROOT / ".pytest_cache" / "kernels"
KEPT = 24 * 3600.0  # [s], age at which an unused cache is removed
PARTS = ("envs", "hysteresis", "identification", "reproductions")  # those of scripts are not


def choose() -> None:
    """Gives numba a folder of these sources only; processes that are started later inherit it.

    Numba's own check of its cache sees a function's file, but not the functions that it calls.
    """
    digest = sha256()
    for path in (*sorted(kernel_sources()), ROOT / "envs" / "numbers.csv"):
        digest.update(path.read_bytes())
    folder = STORE / digest.hexdigest()[:16]
    for other in set(STORE.glob("*")) - {folder}:
        if time.time() - other.stat().st_mtime > KEPT:  # no other test run needs it now
            shutil.rmtree(other, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)


def kernel_sources() -> set[Path]:
    """Returns the files that use numba, and all of the package that these import."""
    files = [*ROOT.glob("*.py"), *(path for part in PARTS for path in (ROOT / part).rglob("*.py"))]
    waiting = [path for path in files if "numba" in path.read_text(encoding="utf-8")]
    found: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(path)
    return found


def _imported(path: Path) -> set[Path]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            modules = [base, *(base / alias.name for alias in node.names)]
            found |= {module.with_suffix(".py") for module in modules}
            found |= {module / "__init__.py" for module in modules}
    return {path for path in found if path.is_file()}


def fill() -> None:
    """Compiles what both test processes need first, in two processes, unless an earlier run did.

    The rest is compiled by the one test process that comes to it, while the other one goes on.
    """
    filled = Path(os.environ["NUMBA_CACHE_DIR"]) / "filled"  # numba makes the folder at an import
    if not filled.exists():
        command = [sys.executable, "-W", "ignore", __file__]
        processes = [subprocess.Popen([*command, half]) for half in HALVES]
        if not any([process.wait() for process in processes]):
            filled.touch()


def jiles_atherton() -> None:
    """Compiles the shipped suits' model in the engine."""
    from activesuit.assets import load_suit

    _in_the_engine(load_suit("mock-suit").joints["elbow_flexion"].model)


def arm_and_bouc_wen() -> None:
    """Compiles the control cycle and the cuffs of an arm without a suit, and Bouc-Wen."""
    from activesuit.envs import ArmEnv
    from activesuit.hysteresis import BoucWen

    arm = ArmEnv(coupling="cuffs", suit="none")
    arm.reset(seed=0)
    arm.step([0.0, 0.0])
    _in_the_engine(BoucWen(elastic=1.0, hysteretic=1.0, A=1.0, beta=1.0, gamma=0.0, n=1.0))


def _in_the_engine(model: "HysteresisModel") -> None:
    import mujoco
    from activesuit.hysteresis.engine import attach

    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(mass=1.0, inertia=[1.0, 1.0, 1.0])
    body.add_joint(name="joint")
    attach(spec, "joint", model)
    spec.compile()


# They take about as long and share little.
HALVES = {half.__name__: half for half in (jiles_atherton, arm_and_bouc_wen)}

if __name__ == "__main__":
    HALVES[sys.argv[1]]()
