"""`activesuit animate`: a looping animation of an assisted motion with its torque-angle loops."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...envs.animation import LoopPanel
from ...envs.arm_env import ArmEnv
from ...envs.evaluation import run_episode
from ...envs.policies import Policy, make_policy
from ...envs.reference import minimum_jerk
from ...errors import InputError
from ...files import replacing
from ..arm_options import USUAL, ArmOptions
from ..options import Gravity, PolicyName, SuitName
from ..output import Bar, progress

Picture = NDArray[np.uint8]

FPS = 25
STRIDE = 4  # control periods between pictures
PERIOD = 6.0  # s
SAMPLES = round(PERIOD * FPS * STRIDE)  # control periods in a cycle
CYCLES = 2  # the last one is filmed, when the suit's memory has become periodic
ARM_WIDTH, PANEL_WIDTH, HEIGHT = 560, 400, 540  # pixels
SHADOWS = 4096  # pixels; what the model asks for takes a second a picture without a graphics card
# When the joints turn, as a fraction of the cycle, and where [rad].
TURNS = {
    "shoulder_flexion": ((0.0, 0.40), (0.27, 1.15), (0.45, 0.75), (0.63, 1.15), (1.0, 0.40)),
    "elbow_flexion": ((-0.04, 1.45), (0.32, 0.60), (0.5, 1.15), (0.66, 0.60), (0.96, 1.45)),
}


def animate(
    out: Path = Path("motion.gif"),
    policy: PolicyName = "feedforward",
    suit: SuitName = "mock-suit",
    gravity: Gravity = "microgravity",
    arm: ArmOptions = USUAL,
    camera: str = "overview",
) -> None:
    """Draw an assisted motion and its torque-angle loops as a looping animation.

    Args:
        out: Name of the film, ending with .gif or .mp4.
        camera: Camera of the film: overview, front, side, elbow, cuffs or follow.
    """
    write = _writer(out)
    env = _Reaching(
        **arm.config(suit, gravity),
        control_dt=1 / (FPS * STRIDE),
        render_mode="rgb_array",
        camera=camera,
        width=ARM_WIDTH,
        height=HEIGHT,
    )
    env.model.vis.quality.shadowsize = SHADOWS
    actor = make_policy(policy, env)
    with replacing(out) as scratch:
        with progress("film", SAMPLES // STRIDE) as bar:
            pictures = _film(env, actor, bar)
        write(scratch, pictures)
    env.close()
    print(f"wrote {out}")


class _Reaching(ArmEnv):
    """A task whose shoulder and elbow reach out twice a cycle, the second time from halfway."""

    duration: ClassVar[float] = CYCLES * PERIOD

    def intended_motion(self, rng: np.random.Generator) -> tuple[Array, Array, Array]:
        del rng
        time = np.linspace(0.0, self.duration, self._samples())
        motion = np.zeros((3, len(time), len(JOINTS)))
        for joint, turns in TURNS.items():
            motion[:, :, JOINTS.index(joint)] = _periodic(time, turns)
        return motion[0], motion[1], motion[2]


class _Filming:
    """A policy that acts as another one and takes pictures of the last cycle."""

    def __init__(self, env: ArmEnv, policy: Policy, bar: Bar) -> None:
        self._env, self._policy, self._bar = env, policy, bar

    def reset(self) -> None:
        self._policy.reset()
        self._step = -(CYCLES - 1) * SAMPLES
        self.pictures: list[Picture] = []

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> Array:
        if self._step >= 0 and self._step % STRIDE == 0:
            picture = self._env.render()
            assert picture is not None
            self.pictures.append(picture)
            self._bar.advance()
        self._step += 1
        return self._policy.act(observation, info)


def _film(env: ArmEnv, policy: Policy, bar: Bar) -> list[Picture]:
    filming = _Filming(env, policy, bar)
    trace = run_episode(env, filming, seed=0)
    if trace.terminated:
        raise InputError(
            f"the arm was lost after {trace.time[-1]:.2f} s: choose another policy or suit"
        )
    # A trace begins after the first control period, the pictures before it.
    cycle = slice(-SAMPLES - 1, -1)
    panel = LoopPanel(
        trace.angle[cycle],
        -trace.suit_torque[cycle],
        trace.human_torque[cycle],
        width=PANEL_WIDTH,
        height=HEIGHT,
    )
    return [
        np.hstack([picture, panel.picture(i * STRIDE)])
        for i, picture in enumerate(filming.pictures)
    ]


def _periodic(time: Array, turns: Sequence[tuple[float, float]]) -> Array:
    """Returns angle, rate and acceleration of periodic minimum-jerk moves between `turns`."""
    motion = np.empty((3, len(time)))
    begin = turns[0][0]
    phase = begin + (time / PERIOD - begin) % 1.0
    for (start, here), (end, there) in pairwise(turns):
        part = (start <= phase) & (phase <= end)
        duration = (end - start) * PERIOD
        move = np.array(minimum_jerk((phase[part] - start) / (end - start)))
        motion[:, part] = (there - here) * move / np.array([[1.0], [duration], [duration**2]])
        motion[0, part] += here
    return motion


def _writer(out: Path) -> Callable[[Path, Sequence[Picture]], None]:
    writers = {".gif": _write_gif, ".mp4": _write_mp4}
    if out.suffix not in writers:
        raise InputError(f"out is {str(out)!r}: use a name that ends with .gif or .mp4")
    if out.suffix == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            raise InputError(
                f"out is {str(out)!r}: .mp4 needs the extra activesuit[video]; .gif does not"
            ) from None
    return writers[out.suffix]


def _write_gif(path: Path, frames: Sequence[Picture]) -> None:
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
    first.save(path, save_all=True, append_images=others, duration=1000 // FPS, loop=0)


def _write_mp4(path: Path, frames: Sequence[Picture]) -> None:
    import imageio.v3 as imageio

    imageio.imwrite(path, frames, plugin="FFMPEG", fps=FPS, macro_block_size=2)
