"""Films of the arm: pictures at a steady rate, written as .gif or .mp4."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from numpy.typing import NDArray

from ..arrays import Array
from ..envs.arm_env import ArmEnv
from ..envs.policies import Policy
from ..envs.rendering import QUALITIES, RenderQuality
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


class Filming:
    """A policy that acts as another one, and takes a picture of every few states it sees.

    Args:
        env: Environment that is filmed.
        policy: Policy that acts.
        stride: Number of control periods between pictures.
        begin: Control period of the first picture.
        on_picture: Function that is called after each picture.

    Attributes:
        pictures: Pictures since the last reset, each (height, width, 3).
        steps: Control periods before each of them.
    """

    def __init__(
        self,
        env: ArmEnv,
        policy: Policy,
        stride: int,
        *,
        begin: int = 0,
        on_picture: Callable[[], None] = lambda: None,
    ) -> None:
        self._env, self._policy, self._stride, self._begin = env, policy, stride, begin
        self._on_picture = on_picture

    def reset(self) -> None:
        """Begins a new film."""
        self._policy.reset()
        self._step = 0
        self.pictures: list[Picture] = []
        self.steps: list[int] = []

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> Array:
        """Returns the action of the policy."""
        if self._step >= self._begin and (self._step - self._begin) % self._stride == 0:
            picture = self._env.render()
            assert picture is not None
            self.pictures.append(picture)
            self.steps.append(self._step)
            self._on_picture()
        self._step += 1
        return self._policy.act(observation, info)


@contextmanager
def filmed(env: ArmEnv, policy: Policy, stride: int, begin: int = 0) -> Iterator[Filming]:
    """Yields a policy that films the episode it runs, and shows how far it is."""
    periods = round(env.duration / env.control_dt)
    with progress("pictures", len(range(begin, periods, stride))) as bar:
        yield Filming(env, policy, stride, begin=begin, on_picture=bar.advance)


def stride_of(fps: int, control_dt: float) -> int:
    """Returns the number of control periods between pictures.

    Raises:
        InputError: `fps` does not divide the control rate, or is too high.
    """
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

    Raises:
        InputError: The format is unknown, or its extra is not installed.
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
