"""Parallel work in threads or processes of this machine, or on a Ray or Dask cluster."""

import importlib
import logging
import os
import secrets
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from multiprocessing import resource_tracker
from typing import Any, Literal, TypeVar, cast

import joblib
from joblib import Parallel, delayed

from ..checks import workers as check_workers
from ..errors import InputError, install_line

Backend = Literal["threading", "loky", "ray", "dask"]
Result = TypeVar("Result")
LIBRARIES = {"dask": ("distributed",), "ray": ("ray", "ray.util.joblib")}


def check_backend(backend: Backend, workers: int) -> None:
    """Checks that `run_all` can use a backend; call this before any work begins."""
    check_workers(workers)
    if backend == "ray" and not os.environ.get("RAY_ADDRESS"):
        # The ports of our own cluster are open to the network, and whoever connects may run code,
        # so the cluster asks for a token. Ray reads these variables when it is imported.
        os.environ.setdefault("RAY_AUTH_MODE", "token")
        os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(32))
    try:
        for module in LIBRARIES.get(backend, ()):
            importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"--backend {backend} needs packages that are not installed ({error}): run "
            f"{install_line('cluster')} in the clone of the repository"
        ) from error


def run_all(
    work: Callable[..., Result], arguments: Iterable[tuple], backend: Backend, workers: int
) -> Iterator[Result]:
    """Calls `work` with each tuple of arguments in parallel; yields each result when it is ready.

    `ray` and `dask` use the cluster that RAY_ADDRESS or DASK_SCHEDULER_ADDRESS names; without that
    variable they start a cluster of `workers` processes on this machine.
    """
    check_backend(backend, workers)
    pending = list(arguments)
    if not pending:
        return
    started = {"dask": _dask, "ray": _ray}.get(backend, nullcontext)
    with (
        started(joblib.cpu_count() if workers < 0 else workers),
        joblib.parallel_config(backend),
        Parallel(
            n_jobs=workers,
            batch_size=1,  # type: ignore[arg-type]  # so that no call waits for another
            return_as="list" if backend == "ray" else "generator_unordered",
        ) as parallel,
    ):
        # Ray's backend cannot hand out results one by one, so it gets the calls in rounds.
        together = joblib.effective_n_jobs(workers) if backend == "ray" else len(pending)
        for first in range(0, len(pending), together):
            calls = (delayed(work)(*call) for call in pending[first : first + together])
            yield from cast(Iterable[Result], parallel(calls))


@contextmanager
def _dask(workers: int) -> Iterator[None]:
    distributed: Any = importlib.import_module("distributed")
    if os.environ.get("DASK_SCHEDULER_ADDRESS"):
        with distributed.Client(os.environ["DASK_SCHEDULER_ADDRESS"]):
            yield
        return
    with ExitStack() as started:
        with _ctrl_c_waiting():
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",  # otherwise Dask warns if port 8787 is in use
            )
            started.enter_context(cluster)
            started.enter_context(distributed.Client(cluster))
        yield


@contextmanager
def _ctrl_c_waiting() -> Iterator[None]:
    """Delays Ctrl-C until the end of the block, also in processes that start in the block."""
    resource_tracker.ensure_running()  # a tracker that starts in the block would unblock Ctrl-C
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _ray(workers: int) -> Iterator[None]:
    ray: Any = importlib.import_module("ray")
    ray_joblib: Any = importlib.import_module("ray.util.joblib")
    started = not ray.is_initialized()
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
    if started and os.environ.get("RAY_ADDRESS"):
        ray.init(**quiet)
    elif started:
        # Our own cluster sends no statistics of usage to Ray.
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        ray.init("local", num_cpus=workers, include_dashboard=False, **quiet)
    ray_joblib.register_ray()
    try:
        yield
    finally:
        if started:
            ray.shutdown()
