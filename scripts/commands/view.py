"""`activesuit view`: shows the moving arm in a window or a browser, as a film or as a picture."""

import itertools
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import mujoco
import numpy as np

from ...checks import check_seed
from ...envs.arm_env import ArmEnv
from ...envs.extras import DRAWINGS
from ...envs.making import make_env
from ...envs.model import ArmConfig, arm_spec
from ...envs.policies import Policy, make_policy, needed_options
from ...envs.rendering import QUALITIES, Capsule, RenderingUnavailableError
from ...errors import InputError
from ...files import check_target, replacing
from ...text import say
from ..browser import PORT, check_address, served
from ..film import PANEL, episode, film_writer, filmed
from ..options import Draw, Force, PolicyName, Seed, Trust, choice, optional_number
from ..scene import scene

FILM, PICTURE = (960, 540), (1280, 960)  # pixels
SMALLEST, LARGEST_FILM, LARGEST = 120, 1920, 4096  # pixels of a side
View = tuple[tuple[float, float, float], float]
WHOLE: View = (-0.25, -0.34, 1.05), 1.75  # [m], middle and size of what a browser shows
WITH_DRAWING: View = (-0.3, -0.65, 1.2), 1.5  # the same, where something is beside the arm
VISOR = (0.85, 0.60, 0.22, 1.0)  # the middle of its texture's gradient


def view(
    policy: PolicyName = "compensation",
    seed: Seed = 0,
    draw: Draw = None,
    web: bool = False,
    host: str = "localhost",
    port: int = PORT,
    film: Path | None = None,
    snapshot: Path | None = None,
    camera: str = "overview",
    size: Annotated[
        tuple[int, int] | None,
        optional_number("960 540 of a film, 1280 960 of a picture", int, 2),
    ] = None,
    quality: Annotated[str | None, choice(lambda: QUALITIES, usual="fast of a film, fine")] = None,
    force: Force = False,
    trust: Trust = False,
    **options: Any,
) -> None:
    """Watch the assisted arm move, in a window or a browser; film or picture it.

    Each next motion has the next seed.

    Args:
        web: Serve to a browser instead of opening a window. Only who has the printed address, which
            holds a token, can use the page; it is not encrypted.
        host: Address that the web page listens on: localhost, which only programs on this machine
            reach, another address of this machine, or 0.0.0.0, which everyone on its networks
            reaches.
        port: Port of the web page and of all that it streams; 0 is the first free one from 8080. A
            second port, for this process itself, listens on localhost only.
        film: File name of a film of one motion with its loops instead, ending with .gif or .mp4
            (which needs the extra activesuit[video]); no display is needed.
        snapshot: File name, ending with .png, of a picture of the beginning of the motion instead;
            no display is needed.
        camera: Camera of film and picture: overview, front, side, elbow, cuffs or follow.
        size: Width and height of film or picture [pixels].
        quality: Quality of the pictures: fine has shadows, smooth edges and reflections, and takes
            a second a picture without a graphics card.
    """
    check_seed(seed)
    if draw is not None and snapshot:
        raise InputError("draw and snapshot are given, and a drawing is of a motion: use --film")
    path = _target(web, film, snapshot, force)
    write = film_writer(film) if film else None
    if web:
        check_address(host, port)
    chosen = scene(options, policies=(policy,), trusted=trust)
    (acting,) = chosen.policies
    options = {**chosen.options, **needed_options(acting)}
    options["render_quality"] = quality or ("fast" if film else "fine")
    options["render_mode"] = None if web else "human"
    panel = 0
    if path:
        width, height = _checked_size(size, film)
        panel = 2 * round(width * PANEL / 2) if film else 0
        options |= {"render_mode": "rgb_array", "camera": camera}
        options |= {"width": width - panel, "height": height}
    made, simulated = make_env(chosen.env, **options)
    actor = make_policy(acting, simulated)
    if draw is not None:
        simulated.renderer.beside = DRAWINGS.find(draw)(simulated.episodes.simulation)
    if path:
        with replacing(path, force=force) as scratch:
            if write:
                write(scratch, *filmed(made, simulated, actor, seed, panel))
            else:
                _take_picture(made, seed, scratch)
        say(f"wrote {path}")
    else:
        with suppress(KeyboardInterrupt):
            if web:
                _serve(simulated, _motions(made, actor, seed), host, port)
            else:
                _open_window(_motions(made, actor, seed))
    made.close()


def _target(web: bool, film: Path | None, snapshot: Path | None, force: bool) -> Path | None:
    """Returns the file to write, or None."""
    given = {"--web": web, "--film": film, "--snapshot": snapshot}
    names = [name for name, value in given.items() if value]
    if len(names) > 1:
        raise InputError(f"{' and '.join(names)} are given: use one of them")
    if snapshot and snapshot.suffix != ".png":
        raise InputError(f"snapshot is {str(snapshot)!r}: use a name that ends with .png")
    path = film or snapshot
    if path:
        check_target(path, force=force)
    return path


def _checked_size(size: tuple[int, int] | None, film: Path | None) -> tuple[int, int]:
    usual, largest = (FILM, LARGEST_FILM) if film else (PICTURE, LARGEST)
    for one in size or usual:
        if not SMALLEST <= one <= largest or one % 2:
            raise InputError(
                f"size has {one}: use even numbers of pixels from {SMALLEST} to {largest}"
            )
    return size or usual


def _motions(env: gymnasium.Env, policy: Policy, seed: int) -> Iterator[Any]:
    """Runs episodes without end; yields after each reset and after each step."""
    for one in itertools.count(seed):
        yield from episode(env, policy, one)


def _open_window(motion: Iterator[Any]) -> None:
    try:
        next(motion)
    except RenderingUnavailableError as error:
        raise InputError(
            "no window can be opened here: use --snapshot FILE.png for a picture, --film FILE.gif "
            "for a film, or --web for a viewer in the browser"
        ) from error
    with suppress(RenderingUnavailableError):  # when the window is closed
        for _ in motion:
            pass


def _serve(env: ArmEnv, motion: Iterator[Any], host: str, port: int) -> None:
    beside = env.renderer.beside
    shown = _drawing(env.config, WITH_DRAWING if beside else WHOLE)
    drawn, capsules = mujoco.MjData(shown), list[Capsule]()
    with served(host, port, capsules) as viewer:
        begin = time.monotonic()
        for step, _ in enumerate(motion):
            if not viewer.is_running():
                break
            if beside is not None:
                capsules[:] = beside()
            drawn.qpos[:] = env.data.qpos
            viewer.sync(shown, drawn)
            time.sleep(max(0.0, begin + step * env.control_dt - time.monotonic()))


def _drawing(config: ArmConfig, seen: View) -> mujoco.MjModel:
    """Returns the model without engine plugins, which MuJoCo in a browser does not have."""
    spec = arm_spec(config)
    for sensor in spec.sensors:  # MuJoCo deletes the plugin that a sensor reads with it
        spec.delete(sensor)
    for plugin in spec.plugins:
        spec.delete(plugin)
    visor = spec.material("visor")  # the browser's renderer stops at a cube texture on metal
    visor.textures = [""] * len(visor.textures)
    visor.rgba = VISOR
    spec.stat.center, spec.stat.extent = seen
    return spec.compile()


def _take_picture(env: gymnasium.Env, seed: int, path: Path) -> None:
    from matplotlib.image import imsave

    env.reset(seed=seed)
    imsave(path, np.asarray(env.render()), format="png")
