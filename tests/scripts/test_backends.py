"""Work in parallel: the same results in threads, processes and clusters."""

import os
import sys
from importlib.util import find_spec

import pytest
from activesuit.errors import InputError
from activesuit.scripts.backends import run_all

CALLS = [(2, power) for power in range(20)]
EXPECTED = [2**power for power in range(20)]


@pytest.mark.parametrize("backend", ["threading", "loky"])
def test_threads_and_processes(backend):
    assert sorted(run_all(pow, CALLS, backend, 2)) == EXPECTED


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "package"), [("dask", "distributed"), ("ray", "ray")])
def test_a_cluster_of_two_workers(backend, package):
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    assert sorted(run_all(pow, CALLS, backend, 2)) == EXPECTED
    if backend == "ray":  # whoever joins may run code, and its ports are open to the network
        assert os.environ["RAY_AUTH_MODE"] == "token"


@pytest.mark.parametrize(("backend", "package"), [("ray", "ray"), ("dask", "distributed")])
def test_a_missing_package(monkeypatch, backend, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf"--backend {backend} needs packages that are not"):
        next(run_all(pow, CALLS, backend, 2))
