"""`activesuit doctor`: checks an installation, and says how to repair failures."""

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
    """The check of one part of an installation."""

    name: str
    ok: bool
    found: str  # result of the check, in words
    mend: str = ""  # how to repair the part
    needed: bool = True  # whether the package cannot work without the part


def doctor(compile: bool = False, json: Json = False) -> None:
    """Check this installation, and say how to repair failures.

    The checks are of the versions of Python and packages, the cache of kernels, the MuJoCo plugins,
    and the drawing of pictures. If a part fails that the package needs, the exit code is 2.

    Args:
        compile: Compile all kernels too, so that no later command waits for a compilation.
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
            yield _extra(extra, requirements)


def _version(requirement: Requirement) -> tuple[str | None, bool]:
    """Returns the installed version, or None, and whether that version is allowed."""
    try:
        version = metadata.version(requirement.name)
    except metadata.PackageNotFoundError:
        return None, False
    return version, requirement.specifier.contains(version, prereleases=True)


def _extra(extra: str, requirements: list[Requirement]) -> Check:
    marked = [(one, one.marker) for one in requirements if one.marker]
    parts = [
        one
        for one, marker in marked
        if marker.evaluate({"extra": extra}) and not marker.evaluate({"extra": ""})
    ]
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
    """Returns a check that fails if `look` raises an error, as a broken package does."""
    try:
        return Check(name=name, ok=True, found=look())
    except InputError as error:  # importing the models raises it, too
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
    """Tries the backend of OpenGL, and the other backends if that backend does not draw."""
    asked = os.environ.get("MUJOCO_GL", "")
    setting = f"MUJOCO_GL={asked}" if asked else "MUJOCO_GL is not set"
    ok, mend = _draws(asked), ""
    if not ok:
        others = (one for one in BACKENDS.get(sys.platform, ()) if one != asked and _draws(one))
        other = next(others, None)
        install = "on Linux run apt install libegl1; only pictures need it"
        mend = f"set MUJOCO_GL={other}" if other else install
    found = f"{'draws' if ok else 'does not draw'} off-screen ({setting})"
    return Check(name="OpenGL", ok=ok, found=found, mend=mend, needed=False)


def _draws(backend: str) -> bool:
    """Returns whether a backend draws, in a new process: MuJoCo reads the name at its import."""
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    try:
        done = subprocess.run(
            [sys.executable, "-c", PICTURE],
            env=environment | ({"MUJOCO_GL": backend} if backend else {}),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0 and "drawn" in done.stdout
