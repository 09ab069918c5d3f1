"""`activesuit view`: shows the moving arm in a window, as a film or as a picture."""

from collections.abc import Iterator
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...checks import check_seed
from ...envs.extras import DRAWINGS
from ...envs.making import make_env
from ...envs.policies import make_policy, needed_options
from ...envs.rendering import QUALITIES, RenderingUnavailableError
from ...errors import InputError
from ...files import check_target, replacing
from ...text import say
from ..film import PANEL, episode, film_writer, filmed
from ..options import Draw, Force, PolicyName, Seed, Trust, choice, optional_number
from ..scene import scene

FILM, PICTURE = (960, 540), (1280, 960)  # pixels
SMALLEST, LARGEST_FILM, LARGEST = 120, 1920, 4096  # pixels of a side


def view(
    policy: PolicyName = "compensation",
    seed: Seed = 0,
    draw: Draw = None,
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
    """Watch the assisted arm move in a window; film or picture it.

    In a window each motion is followed by the motion of the next seed.

    Args:
        film: File name of a film of one motion with its loops, in place of a window; the name ends
            with .gif or .mp4 (mp4 needs the extra activesuit[video]). No display is needed.
        snapshot: File name of a picture of the beginning of the motion, in place of a window; the
            name ends with .png. No display is needed.
        camera: Camera of film and picture: overview, front, side, elbow, cuffs or follow.
        size: Width and height of film or picture [pixels].
        quality: Quality of the pictures: fine has shadows, smooth edges and reflections, and takes
            a second for each picture without a graphics card.
    """
    check_seed(seed)
    if draw is not None and snapshot:
        raise InputError("draw and snapshot are given, and a drawing is of a motion: use --film")
    path = _target(film, snapshot, force)
    write = film_writer(film) if film else None
    chosen = scene(options, policies=(policy,), trusted=trust)
    (acting,) = chosen.policies
    options = {**chosen.options, **needed_options(acting)}
    options["render_quality"] = quality or ("fast" if film else "fine")
    options["render_mode"] = "human"
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
        from matplotlib.image import imsave

        with replacing(path, force=force) as scratch:
            if write:
                write(scratch, *filmed(made, simulated, actor, seed, panel))
            else:
                made.reset(seed=seed)
                imsave(scratch, np.asarray(made.render()), format="png")
        say(f"wrote {path}")
    else:
        with suppress(KeyboardInterrupt):
            _open_window(chain.from_iterable(episode(made, actor, one) for one in count(seed)))
    made.close()


def _target(film: Path | None, snapshot: Path | None, force: bool) -> Path | None:
    """Returns the file to write, or None."""
    if film and snapshot:
        raise InputError("--film and --snapshot are given: use one of them")
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


def _open_window(motion: Iterator[Any]) -> None:
    try:
        next(motion)
    except RenderingUnavailableError as error:
        raise InputError(
            "no window can be opened here: use --snapshot FILE.png for a picture, or --film "
            "FILE.gif for a film"
        ) from error
    with suppress(RenderingUnavailableError):  # when the window is closed
        for _ in motion:
            pass
