"""Films of the arm beside its torque-angle loops, written as .gif or .mp4."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from ..envs.animation import LoopPanel
from ..envs.arm_env import ArmEnv
from ..envs.policies import Policy
from ..errors import InputError, shown
from ..text import say
from .output import progress

Picture = NDArray[np.uint8]
PERIOD = 0.04  # [s], from one picture to the next
PANEL = 5 / 12  # share of the width of the film


def episode(env: gymnasium.Env, policy: Policy, seed: int) -> Iterator[tuple[Any, bool]]:
    """Yields the info, and whether the arm is lost, after the reset and after each step."""
    observation, info = env.reset(seed=seed)
    policy.reset()
    ended = lost = False
    yield info, lost
    while not ended:
        observation, _, lost, truncated, info = env.step(policy.act(observation))
        ended = lost or truncated
        yield info, lost


def filmed(
    made: gymnasium.Env, env: ArmEnv, policy: Policy, seed: int, panel: int
) -> tuple[list[Picture], float]:
    """Films an episode; returns the pictures, and the time between two pictures [s]."""
    stride = max(1, round(PERIOD / env.control_dt))
    frames, series = [], []
    with progress("pictures", round(env.duration / env.control_dt) // stride + 1) as bar:
        for step, (info, lost) in enumerate(episode(made, policy, seed)):
            if step:  # at the reset the motors do nothing yet
                now = info["angle"], -info["suit_torque"], info["human_torque"]
                series.append(np.array(now))
            if env.renderer.beside is not None:
                env.renderer.beside()  # a drawing follows every control period
            if step % stride == 0:
                frames.append(np.asarray(made.render()))
                bar.advance()
            if lost:
                say(f"the arm was lost after {info['time']:.2f} s; the film ends there")
    loops = LoopPanel(*np.stack(series, axis=1), width=panel, height=len(frames[0]))
    with progress("panels beside the arm", len(frames)) as bar:
        for i, frame in enumerate(frames):
            frames[i] = np.hstack([frame, loops.picture(max(i * stride - 1, 0))])
            bar.advance()
    return frames, stride * env.control_dt


def film_writer(path: Path) -> Callable[[Path, Sequence[Picture], float], None]:
    """Returns the function that writes pictures, with the time between them [s], into a film."""
    if path.suffix not in FILMS:
        raise InputError(f"film is {shown(str(path))}: use a name that ends with .gif or .mp4")
    if path.suffix == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            raise InputError(
                f"film is {shown(str(path))}: mp4 needs the extra activesuit[video]; gif does not"
            ) from None
    return FILMS[path.suffix]


def _write_gif(path: Path, frames: Sequence[Picture], period: float) -> None:
    from PIL import Image  # matplotlib's own dependency

    some = Image.fromarray(np.vstack(frames[:: max(1, len(frames) // 6)]))
    # 64 colors for large smooth areas, and 192 for small areas that stand out.
    large = some.quantize(64, Image.Quantize.MEDIANCUT, kmeans=1)
    small = some.quantize(192, Image.Quantize.MAXCOVERAGE, kmeans=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((large.getpalette() or [])[: 3 * 64] + (small.getpalette() or [])[: 3 * 192])
    first, *others = (
        Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    first.save(path, save_all=True, append_images=others, duration=round(1000 * period), loop=0)


def _write_mp4(path: Path, frames: Sequence[Picture], period: float) -> None:
    import imageio.v3 as imageio

    imageio.imwrite(path, frames, plugin="FFMPEG", fps=1 / period, macro_block_size=2)


FILMS = {".gif": _write_gif, ".mp4": _write_mp4}
