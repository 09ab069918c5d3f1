"""`activesuit doctor`: checks an installation, and says how to mend what fails."""

import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib import metadata

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from ...errors import InputError, install_line
from ...text import say
from ..folders import to_json
from ..options import Json

PACKAGE = "activesuit"
NOT_FOR_USERS = ("dev",)  # extras that only the development of this package needs
BACKENDS = {"linux": ("egl", "osmesa", "glfw"), "darwin": ("cgl",), "win32": ("wgl",)}
PATIENCE = 60  # [s], time for one picture
PICTURE = """
import mujoco
model = mujoco.MjModel.from_xml_string(
    '<mujoco><worldbody><light pos="0 0 3"/><geom size="1"/></worldbody></mujoco>'
)
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 32, 32) as renderer:
    renderer.update_scene(data)
    print("drawn" if renderer.render().any() else "black")
"""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: What it is.
        ok: Whether it is there and works.
        found: What was found, in words.
        mend: How to mend it; empty if nothing fails.
        needed: Whether the package cannot do without it.
    """

    name: str
    ok: bool
    found: str
    mend: str = ""
    needed: bool = True


def doctor(compile: bool = False, json: Json = False) -> None:
    """Check this installation, and say how to mend what fails.

    It checks the versions of Python and packages, the cache of kernels, the MuJoCo plugins, and
    whether pictures can be drawn. If something that is needed fails, the exit code is 2.

    Args:
        compile: Compile all kernels too, so that no later command waits for them.
    """
    checks = []
    for check in _checks(compile):
        checks.append(check)
        if not json:
            mark = "ok" if check.ok else "FAILS" if check.needed else "-"
            say(f"{mark:6}{check.name}: {check.found}{'; ' * bool(check.mend)}{check.mend}")
    failed = [check.name for check in checks if check.needed and not check.ok]
    if json:
        print(to_json({"ok": not failed, "checks": [asdict(check) for check in checks]}))
    if failed:
        raise InputError(f"{', '.join(failed)} must be mended: each line above says how")


def _checks(compile: bool) -> Iterator[Check]:
    try:
        about = metadata.metadata(PACKAGE)
        requirements = [Requirement(one) for one in metadata.requires(PACKAGE) or ()]
    except metadata.PackageNotFoundError:
        yield Check(name=PACKAGE, ok=False, found="not installed", mend="run pip install .")
        return
    yield Check(name=PACKAGE, ok=True, found=f"version {about['Version']}")
    python, wanted = platform.python_version(), about["Requires-Python"]
    ok = python in SpecifierSet(wanted, prereleases=True)
    yield Check(name="python", ok=ok, found=python, mend="" if ok else f"use Python {wanted}")
    for one in requirements:
        if one.marker is None:
            version, ok = _version(one)
            mend = "" if ok else f"run pip install '{one.name}{one.specifier}'"
            yield Check(name=one.name, ok=ok, found=version or "not installed", mend=mend)
    yield _tried("kernel cache", _cache)
    yield _tried("MuJoCo plugins", _plugins)
    if compile:
        yield _tried("kernels", _kernels)
    yield _pictures()
    for extra in about.get_all("Provides-Extra") or ():
        if extra not in NOT_FOR_USERS:
            yield _extra(extra, [one for one in requirements if _is_of(one, extra)])


def _is_of(requirement: Requirement, extra: str) -> bool:
    marker = requirement.marker
    return bool(marker) and marker.evaluate({"extra": extra}) and not marker.evaluate({"extra": ""})


def _version(requirement: Requirement) -> tuple[str | None, bool]:
    """Returns the version that is installed, or None, and whether the version fits."""
    try:
        version = metadata.version(requirement.name)
    except metadata.PackageNotFoundError:
        return None, False
    return version, requirement.specifier.contains(version, prereleases=True)


def _extra(extra: str, parts: list[Requirement]) -> Check:
    missing = [one.name for one in parts if not _version(one)[1]]
    present = ", ".join(f"{one.name} {_version(one)[0]}" for one in parts)
    return Check(
        name=f"extra {extra}",
        ok=not missing,
        found=f"lacks {', '.join(missing)}" if missing else present,
        mend=f"run {install_line(extra)} in the clone to use it" if missing else "",
        needed=False,
    )


def _tried(name: str, look: Callable[[], str]) -> Check:
    """Returns a check that fails in any way that code can, as where a package is broken."""
    try:
        return Check(name=name, ok=True, found=look())
    except InputError as error:  # which importing the models raises too
        return Check(name=name, ok=False, found="cannot be used", mend=str(error))
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        return Check(name=name, ok=False, found=why, mend="mend what fails above, or reinstall it")


def _cache() -> str:
    from ...hysteresis.first_use import CACHE, cache_folder, check_cache

    check_cache()
    return f"{os.environ.get(CACHE) or cache_folder()} (doctor --compile fills it)"


def _plugins() -> str:
    from ...envs.model import bushing
    from ...hysteresis import engine

    return f"{len([*engine.register(), bushing.PLUGIN_NAME])} are registered"


def _kernels() -> str:
    from ..compiling import compile_kernels

    return f"all are compiled, {compile_kernels() or 'none'} of them now"


def _pictures() -> Check:
    """Tries every backend of OpenGL in a process of its own: MuJoCo reads its name at import."""
    asked = os.environ.get("MUJOCO_GL", "")
    backends = dict.fromkeys([asked, *BACKENDS.get(sys.platform, ())])
    running = {one: _drawing(one) for one in backends}
    draws = {one: _draws(process) for one, process in running.items()}
    others = [one for one, works in draws.items() if works and one not in ("", asked)]
    setting = f"MUJOCO_GL={asked}" if asked else "MUJOCO_GL is not set"
    mend = ""
    if not draws[asked]:
        install = "on Linux run apt install libegl1; all but pictures works without"
        mend = f"set MUJOCO_GL={others[0]}" if others else install
    return Check(
        name="OpenGL",
        ok=draws[asked],
        found=f"{'draws' if draws[asked] else 'does not draw'} off-screen ({setting})",
        mend=mend,
        needed=False,
    )


def _drawing(backend: str) -> subprocess.Popen:
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    return subprocess.Popen(
        [sys.executable, "-c", PICTURE],
        env=environment | ({"MUJOCO_GL": backend} if backend else {}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _draws(process: subprocess.Popen) -> bool:
    try:
        shown, _ = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return False
    return process.returncode == 0 and "drawn" in shown
