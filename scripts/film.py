"""Films of the arm: pictures at a steady rate, written as .gif or .mp4."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from numpy.typing import NDArray

from ..envs.rendering import QUALITIES, RenderQuality
from ..envs.vector_env import ArmVectorEnv
from ..errors import InputError, shown, unknown_name
from .options import choice
from .output import progress

Picture = NDArray[np.uint8]

FPS = 25
FASTEST = 50  # pictures per second; browsers slow down a .gif that is faster
Quality = Annotated[
    RenderQuality,
    choice(
        lambda: QUALITIES,
        "Quality of the pictures: fine has shadows, smooth edges and reflections, and takes a "
        "second a picture without a graphics card.",
    ),
]
Fps = Annotated[
    int,
    tyro.conf.arg(
        help="Pictures per second, a divisor of the control rate, which usually is 100 Hz."
    ),
]


class Film:
    """Pictures of an episode, taken every few control periods.

    Call it before each control period with its number, as `rollout` does.

    Args:
        arms: Vector environment, whose first row is filmed.
        stride: Number of control periods between pictures.
        begin: Control period of the first picture.
        on_picture: Function that is called after each picture.

    Attributes:
        pictures: Pictures so far, each (height, width, 3).
        steps: Control periods before each of them.
    """

    def __init__(
        self, arms: ArmVectorEnv, stride: int, begin: int, on_picture: Callable[[], None]
    ) -> None:
        self._arms, self._stride, self._begin = arms, stride, begin
        self._on_picture = on_picture
        self.pictures: list[Picture] = []
        self.steps: list[int] = []

    def __call__(self, step: int) -> None:
        """Takes a picture, if control period `step` is one of those with a picture."""
        if self._arms.renderer.beside is not None:
            self._arms.renderer.beside()  # which wants to see every control period
        if step < self._begin or (step - self._begin) % self._stride:
            return
        pictures = self._arms.render()
        assert pictures is not None
        self.pictures.append(pictures[0])
        self.steps.append(step)
        self._on_picture()


@contextmanager
def filmed(arms: ArmVectorEnv, stride: int, begin: int = 0) -> Iterator[Film]:
    """Yields a film of the next episode, and shows how far it is."""
    periods = round(arms.duration / arms.control_dt)
    with progress("pictures", len(range(begin, periods, stride))) as bar:
        yield Film(arms, stride, begin, bar.advance)


def stride_of(fps: int, control_dt: float) -> int:
    """Returns the number of control periods between pictures."""
    rate = round(1 / control_dt)
    usable = [n for n in range(1, min(rate, FASTEST) + 1) if rate % n == 0]
    if fps not in usable:
        raise InputError(
            f"fps is {shown(fps)}: use {', '.join(map(str, usable[:-1]))} or {usable[-1]}, which "
            f"divide the control rate, {rate} Hz"
        )
    return rate // fps


def film_writer(
    kind: str, name: str = "video", value: str | None = None
) -> Callable[[Path, Sequence[Picture], int], None]:
    """Returns the function that writes pictures into a film, at a number of pictures per second.

    Args:
        kind: Format, gif or mp4.
        name: Name of the option that says so.
        value: Value of that option; by default the format.
    """
    if kind not in FILMS:
        raise unknown_name(name, kind, list(FILMS))
    if kind == "mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            raise InputError(
                f"{name} is {shown(value or kind)}: mp4 needs the extra activesuit[video]; gif "
                "does not"
            ) from None
    return FILMS[kind]


def _write_gif(path: Path, frames: Sequence[Picture], fps: int) -> None:
    from PIL import Image  # matplotlib's own dependency

    some = Image.fromarray(np.vstack(frames[:: max(1, len(frames) // 6)]))
    # Some colors for smooth large areas, the others for small ones that stand out.
    large = some.quantize(64, Image.Quantize.MEDIANCUT, kmeans=1)
    small = some.quantize(192, Image.Quantize.MAXCOVERAGE, kmeans=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((large.getpalette() or [])[: 3 * 64] + (small.getpalette() or [])[: 3 * 192])
    first, *others = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    first.save(path, save_all=True, append_images=others, duration=1000 // fps, loop=0)


def _write_mp4(path: Path, frames: Sequence[Picture], fps: int) -> None:
    import imageio.v3 as imageio

    imageio.imwrite(path, frames, plugin="FFMPEG", fps=fps, macro_block_size=2)


FILMS = {"gif": _write_gif, "mp4": _write_mp4}
Video = Annotated[
    str | None,
    choice(
        lambda: FILMS,
        "Film the motion too, as motion.gif or motion.mp4, which needs the extra activesuit[video] "
        "and plays everywhere.",
        "no film",
    ),
]
