"""Settings that make tests quick and repeatable, and data that many of them share."""

import gc
import os

import kernel_cache

# Before anything imports numpy and numba. A second thread of BLAS, torch or joblib in each of two
# test processes takes more time than it saves.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("LOKY_MAX_CPU_COUNT", "1")
kernel_cache.choose()

import activesuit.scripts  # noqa: E402, F401  (chooses EGL on a machine without a display)
import hypothesis  # noqa: E402
import numpy as np  # noqa: E402
import pytest  # noqa: E402
from activesuit.hysteresis import JilesAtherton  # noqa: E402
from activesuit.identification import Curve  # noqa: E402
from activesuit.scripts.folders import close_folders  # noqa: E402
from helpers import TABLE_2, shorten_tasks, sweep, without_figures  # noqa: E402

# The same examples in every run and process. To look for new ones: --hypothesis-profile=default.
hypothesis.settings.register_profile("repeatable", derandomize=True)
hypothesis.settings.load_profile("repeatable")


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session):
    """Compiles kernels before test processes start, which would all do it otherwise."""
    if getattr(session.config.option, "dist", "no") != "no":
        kernel_cache.fill()


def pytest_collection_finish(session):
    """Keeps the garbage collector from the objects of imported modules, which stay."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000)


@pytest.fixture(scope="module", autouse=True)
def this_machine(tmp_path_factory):
    """Keeps notes of the files that this machine wrote out of the user's own notes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture
def closed():
    """Closes run folders after a test that opens them without a command."""
    yield
    close_folders()


@pytest.fixture
def short(monkeypatch):
    """Episodes take 0.5 s instead of 10 s."""
    shorten_tasks(monkeypatch, 0.5)


@pytest.fixture
def undrawn():
    """For tests of commands whose figures others look at."""
    with without_figures():
        yield


@pytest.fixture(scope="session")
def table_2() -> dict[str, JilesAtherton]:
    """The four published models."""
    return {
        name: JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
        for name, (Ms, a, alpha, c, k) in TABLE_2.items()
    }


@pytest.fixture(scope="session")
def elbow(table_2) -> JilesAtherton:
    """The published elbow, which is certified."""
    return table_2["elbow-sa-pso"]


@pytest.fixture(scope="session")
def shoulder(table_2) -> JilesAtherton:
    """The published shoulder, which is not certified."""
    return table_2["shoulder-sa-pso"]


@pytest.fixture(scope="session")
def small_family(elbow) -> list[Curve]:
    """Three fitted and one predicted elbow curve with 1 % noise, coarse enough to be fast."""
    rng = np.random.default_rng(0)
    curves = []
    for turn, role in ((0.87, "fit"), (1.22, "fit"), (1.57, "fit"), (1.40, "predict")):
        angle = sweep(0.52, turn, 0.52, samples=60)
        noise = 0.057 * rng.standard_normal(angle.size)
        curves.append(Curve(angle, elbow.response(angle) + noise, f"{turn:.2f}", role))
    return curves
