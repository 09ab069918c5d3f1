"""A first use that compiles for long says so, once, and names the cache."""

import pickle

import numba
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import first_use
from activesuit.hysteresis.engine import native
from numba.core import caching


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(first_use.time, "monotonic", lambda: now[0])
    return now


def test_long_compiling_is_announced_once_and_progress_later(capsys, clock):
    listener = first_use.FirstUse()
    for seconds in (0.5, 1.0):
        listener.on_start(None)
        clock[0] += seconds
        listener.on_end(None)
        clock[0] += 100  # what happens between two functions is not compiling
    assert capsys.readouterr().err == ""
    listener.on_start(None)
    clock[0] += 0.6
    listener.on_start(None)  # a function inside
    assert capsys.readouterr().err == first_use.MESSAGE + "\n"
    listener.on_end(None)
    listener.on_end(None)
    clock[0] += 100
    listener.on_start(None)
    assert capsys.readouterr().err == ""
    clock[0] += 6
    listener.on_end(None)
    assert "activesuit: 5 kernels are compiled after 8 s" in capsys.readouterr().err
    for _ in range(100):  # an hour of compilation is a few lines
        listener.on_start(None)
        clock[0] += 36
        listener.on_end(None)
    assert 2 < len(capsys.readouterr().err.splitlines()) < 10


def test_a_cache_that_others_may_write_is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv(first_use.CACHE, str(tmp_path))
    first_use.check_cache()
    tmp_path.chmod(0o777)
    with pytest.raises(InputError, match="where other users may write, and its files are code"):
        first_use.check_cache()


def test_without_any_cache_one_sentence_says_what_to_do(monkeypatch):
    def no_locator(**options):
        raise RuntimeError("cannot cache function")

    monkeypatch.setattr(first_use, "njit", no_locator)
    with pytest.raises(InputError, match="set NUMBA_CACHE_DIR to a folder that you may write"):
        first_use.check_cache()


def test_a_plugin_is_compiled_when_it_is_needed_and_once():
    built = []

    def build():
        built.append("now")

        def nstate(instance):
            return 0

        return (nstate,)

    slots = [native.register_plugin("test.late", ("joint",), build) for _ in range(2)]
    assert slots[0] == slots[1]
    assert not built
    for _ in range(2):
        native.compile_plugin("test.late")
    assert built == ["now"]


def test_a_cache_with_types_of_an_older_version_counts_as_empty(tmp_path):
    index = caching.IndexDataCacheFile(str(tmp_path), "kernel", "stamp")
    index.save("signature", 5)
    assert index.load("signature") == 5
    gone = b"cactivesuit.gone\nMotor\n."  # a pickle that names a class of a module that is gone
    (tmp_path / "kernel.nbi").write_bytes(pickle.dumps(numba.__version__) + gone)
    assert index.load("signature") is None
    index.save("signature", 6)
    assert index.load("signature") == 6
