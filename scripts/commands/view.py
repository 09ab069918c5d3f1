"""`activesuit view`: shows the moving arm in a window or a browser, or draws a picture of it."""

import itertools
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import gymnasium
import mujoco

from ...checks import check_seed
from ...envs.extras import DRAWINGS
from ...envs.making import make_env
from ...envs.model import ArmConfig, arm_spec, compose
from ...envs.policies import Policy, make_policy, needed_options
from ...envs.rendering import Renderer, RenderingUnavailableError
from ...errors import InputError, unknown_name
from ...files import check_target, replacing
from ..arm_options import USUAL, ArmOptions
from ..browser import PORT, check_address, served
from ..film import Quality
from ..live import panel
from ..options import Draw, Env, Force, Gravity, PolicyName, Seed, Suit, Trust
from ..output import say
from ..runs import scene
from ..stage import Stage

LARGEST = 4096  # pixels of a side of a snapshot
View = tuple[tuple[float, float, float], float]
WHOLE: View = (-0.25, -0.34, 1.05), 1.75  # [m], middle and size of what a browser shows
WITH_DRAWING: View = (-0.3, -0.65, 1.2), 1.5  # the same, where something is beside the arm
VISOR = (0.85, 0.60, 0.22, 1.0)  # the middle of its texture's gradient


def view(
    env: Env = None,
    policy: PolicyName = "feedforward",
    suit: Suit = None,
    gravity: Gravity = None,
    arm: ArmOptions = USUAL,
    seed: Seed = 0,
    draw: Draw = None,
    web: bool = False,
    host: str = "localhost",
    port: int = PORT,
    snapshot: Path | None = None,
    camera: str = "overview",
    pose: str = "home",
    width: int = 1280,
    height: int = 960,
    quality: Quality = "fine",
    force: Force = False,
    trust: Trust = False,
) -> None:
    """Watch the assisted arm move, in a window or a browser; or take a picture of it.

    Each next motion has the next seed.

    Args:
        web: Serve to a browser instead of opening a window. Only who has the printed address, which
            holds a token, can use the page; it is not encrypted.
        host: Address that the web page listens on: localhost, which only programs on this machine
            reach, another address of this machine, or 0.0.0.0, which everyone on its networks
            reaches.
        port: Port of the web page and of all that it streams; 0 is the first free one from 8080. A
            second port, for this process itself, listens on localhost only.
        snapshot: File name, ending with .png, of a picture to draw instead, without a display.
        camera: Camera of the snapshot: overview, front, side, elbow, cuffs or follow.
        pose: Pose of the arm in the snapshot: home or reach.
        width: Width of the snapshot [pixels].
        height: Height of the snapshot [pixels].
    """
    check_seed(seed)
    if draw is not None and snapshot is not None:
        raise InputError(
            "both draw and snapshot are given, and a drawing is of a moving arm: use animate --draw"
        )
    chosen = scene(arm, env=env, suit=suit, gravity=gravity, policies=(policy,), trusted=trust)
    (acting,) = chosen.policies
    if snapshot is not None:
        if web:
            raise InputError("both web and snapshot are given: use one of them")
        renderer = Renderer(camera=camera, width=width, height=height, quality=quality)
        _take_picture(ArmConfig.from_dict(chosen.arm), snapshot, renderer, pose, force)
        return
    if web:
        check_address(host, port)
        with suppress(KeyboardInterrupt):
            stage = Stage(chosen, seed, draw=draw)
            _serve(stage, host, port, WITH_DRAWING if draw else WHOLE)
        return
    made, simulated = make_env(
        chosen.env,
        **{**chosen.options, **needed_options(acting)},
        render_mode="human",
        render_quality=quality,
    )
    if draw is not None:
        simulated.renderer.beside = DRAWINGS.find(draw)(simulated.episodes.simulation)
    with suppress(KeyboardInterrupt):
        _open_window(_move(made, make_policy(acting, simulated), seed))
    made.close()


def _move(env: gymnasium.Env, policy: Policy, seed: int) -> Iterator[None]:
    """Runs episodes without end; yields after each reset and after each step."""
    for episode in itertools.count(seed):
        observation, _ = env.reset(seed=episode)
        policy.reset()
        ended = False
        while not ended:
            yield
            observation, _, terminated, truncated, _ = env.step(policy.act(observation))
            ended = terminated or truncated


def _open_window(motion: Iterator[None]) -> None:
    try:
        next(motion)
    except RenderingUnavailableError as error:
        raise InputError(
            "no window can be opened here: use --snapshot FILE.png for a picture, or --web for a "
            "viewer in the browser"
        ) from error
    with suppress(RenderingUnavailableError):  # when the window is closed
        for _ in motion:
            pass


def _serve(stage: Stage, host: str, port: int, seen: View) -> None:
    simulated, shown = stage.env, _drawing(stage.env.config, seen)
    drawn = mujoco.MjData(shown)
    with served(host, port, panels=[panel(stage.live)]) as viewer:
        begin = time.monotonic()
        for step, env in enumerate(stage.motion()):
            if not viewer.is_running():
                break
            if env is not simulated:
                simulated, shown = env, _drawing(env.config, seen)
                drawn = mujoco.MjData(shown)
                begin = time.monotonic() - step * env.control_dt
            drawn.qpos[:] = env.data.qpos
            viewer.sync(shown, drawn)
            time.sleep(max(0.0, begin + step * env.control_dt - time.monotonic()))
    stage.env.close()


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


def _take_picture(
    config: ArmConfig, path: Path, renderer: Renderer, pose: str, force: bool
) -> None:
    if path.suffix != ".png":
        raise InputError(f"snapshot is {str(path)!r}: use a name that ends with .png")
    for name, size in (("width", renderer.width), ("height", renderer.height)):
        if size > LARGEST:
            raise InputError(f"{name} is {size}: use 1 to {LARGEST} pixels")
    check_target(path, force=force)
    model = compose(config)
    poses = [model.key(i).name for i in range(model.nkey)]
    if pose not in poses:
        raise unknown_name("pose", pose, poses)
    model.vis.global_.offwidth, model.vis.global_.offheight = renderer.width, renderer.height
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(pose).id)
    mujoco.mj_forward(model, data)
    with replacing(path, force=force) as scratch:
        from matplotlib.image import imsave

        imsave(scratch, renderer.picture(model, data), format="png")
    renderer.close()
    say(f"wrote {path}")
