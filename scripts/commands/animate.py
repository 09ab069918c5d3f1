"""`activesuit animate`: an animation of an assisted motion with its torque-angle loops."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...checks import check_seed
from ...envs.animation import LoopPanel
from ...envs.evaluation import rollout
from ...envs.extras import DRAWINGS
from ...envs.making import make_arms
from ...envs.policies import Policy, make_policy, needed_options
from ...envs.simulation.plan import Motion
from ...envs.tasks import Task
from ...envs.tasks.motions import minimum_jerk
from ...envs.vector_env import ArmVectorEnv
from ...errors import InputError, shown
from ...files import check_target, replacing
from ..arm_options import USUAL, ArmOptions
from ..film import FILMS, FPS, Fps, Picture, Quality, film_writer, filmed, stride_of
from ..options import Draw, Force, PolicyName, Seed, Suit, Trust, env_option, gravity_option
from ..output import progress, say
from ..runs import scene
from ..settings import LIMIT

PERIOD = 6.0  # s
CYCLES = 2  # the last one is filmed, when the suit's memory has become periodic
PANEL = 5 / 12  # share of the width
SMALLEST, LARGEST = 120, 1920  # pixels of a side
REACH = "a looping reach"
# When the joints turn, as a fraction of the cycle, and where [rad].
TURNS = {
    "shoulder_flexion": ((0.0, 0.40), (0.27, 1.15), (0.45, 0.75), (0.63, 1.15), (1.0, 0.40)),
    "elbow_flexion": ((-0.04, 1.45), (0.32, 0.60), (0.5, 1.15), (0.66, 0.60), (0.96, 1.45)),
}


def animate(
    out: Path = Path("motion.gif"),
    env: Annotated[str | None, env_option(REACH)] = None,
    policy: PolicyName = "feedforward",
    suit: Suit = None,
    gravity: Annotated[str | None, gravity_option("microgravity")] = None,
    arm: ArmOptions = USUAL,
    seed: Seed = 0,
    draw: Draw = None,
    camera: str = "overview",
    fps: Fps = FPS,
    width: int = 960,
    height: int = 540,
    quality: Quality = "fast",
    force: Force = False,
    trust: Trust = False,
) -> None:
    """Draw an assisted motion with its loops as an animation.

    Without an environment it is a reach that loops without a seam; with one, a whole episode.

    Args:
        out: Name of the film, ending with .gif or .mp4 (which needs the extra activesuit[video]).
        camera: Camera of the film: overview, front, side, elbow, cuffs or follow.
        width: Width of the film [pixels].
        height: Height of the film [pixels].
    """
    write = _writer(out, force)
    check_seed(seed)
    _check_size(width, height)
    usual = {"env": REACH, "gravity": "microgravity"}
    chosen = scene(
        arm,
        env=env,
        suit=suit,
        gravity=gravity,
        policies=(policy,),
        trusted=trust,
        usual=usual,
    )
    (acting,) = chosen.policies
    panel_width = 2 * round(width * PANEL / 2)
    options = {
        **chosen.options,
        "render_mode": "rgb_array",
        "camera": camera,
        "width": width - panel_width,
        "height": height,
        "render_quality": quality,
        **needed_options(acting),
    }
    if chosen.env == REACH:
        if LIMIT in options:
            raise InputError(f"--set gives {LIMIT}, and {REACH} has its own length: add --env")
        arms = ArmVectorEnv(1, _Reaching(name="Reaching", duration=CYCLES * PERIOD), **options)
    else:
        arms = make_arms(chosen.env, 1, **options)
    if draw is not None:
        arms.renderer.beside = DRAWINGS.find(draw)(arms.episodes.simulation)
    stride = stride_of(fps, arms.control_dt)
    actor = make_policy(acting, arms)
    with replacing(out, force=force) as scratch:
        write(scratch, _film(arms, actor, seed, stride, panel_width, height), fps)
    arms.close()
    say(f"wrote {out}")


class _Reaching(Task):
    """A task whose shoulder and elbow reach out twice a cycle, the second time from halfway."""

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        del rng
        time = dt * np.arange(samples, dtype=np.float64)
        motion = np.zeros((3, samples, len(JOINTS)))
        for joint, turns in TURNS.items():
            motion[:, :, JOINTS.index(joint)] = _periodic(time, turns)
        return motion[0], motion[1], motion[2]


def _film(
    arms: ArmVectorEnv, policy: Policy, seed: int, stride: int, width: int, height: int
) -> list[Picture]:
    """Films a whole episode, or the last cycle of a periodic motion, with a panel of that size."""
    samples, reaching = round(arms.duration / arms.control_dt), isinstance(arms.task, _Reaching)
    cycle = samples // CYCLES if reaching else samples
    with filmed(arms, stride, begin=samples - cycle) as film:
        (trace,) = rollout(arms, policy, [seed], on_step=film)
    if trace.terminated:
        lost = f"the arm was lost after {trace.time[-1]:.2f} s"
        if reaching:
            raise InputError(f"{lost}: choose another policy or suit")
        say(f"{lost}; the film ends there")
    # A trace begins after the first control period, the pictures before it.
    if reaching:
        part, shift = slice(-cycle - 1, -1), samples - cycle
    else:
        part, shift = slice(None), 1
    torques = -trace.suit_torque[part], trace.human_torque[part]
    panel = LoopPanel(trace.angle[part], *torques, width=width, height=height, closed=reaching)
    frames = film.pictures
    with progress("panels beside the arm", len(frames)) as bar:
        for i, step in enumerate(film.steps):
            frames[i] = np.hstack([frames[i], panel.picture(max(step - shift, 0))])
            bar.advance()
    return frames


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


def _writer(out: Path, force: bool) -> Callable[[Path, Sequence[Picture], int], None]:
    kind = out.suffix.removeprefix(".")
    if kind not in FILMS:
        raise InputError(f"out is {shown(str(out))}: use a name that ends with .gif or .mp4")
    check_target(out, force=force)
    return film_writer(kind, "out", str(out))


def _check_size(width: int, height: int) -> None:
    for name, size in (("width", width), ("height", height)):
        if not SMALLEST <= size <= LARGEST or size % 2:
            raise InputError(
                f"{name} is {size}: use an even number of pixels from {SMALLEST} to {LARGEST}"
            )
