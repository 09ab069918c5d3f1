"""Steps of many worlds in MuJoCo Warp, with hysteresis and without (needs the extra `gpu`)."""

# pyright: reportInvalidTypeForm=false

import platform
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from ..checks import at_least, once
from ..envs.model import ArmConfig, for_warp, resisting_joints
from ..errors import InputError
from ..hysteresis.warp import attach
from ..scripts.folders import to_json
from ..scripts.output import table
from .timing import Row, compare

WORLDS = (1024, 4096, 16384)
VARIED = 64  # different models of each joint; world i has number i modulo 64
GPU_STEPS, WORLD_STEPS = 200, 4096  # of a measurement: on a GPU; of all worlds on a processor
CONTACTS, CONSTRAINTS = 8, 16  # most of a world
AMPLITUDE, MIDDLE = 0.35, (0.0, 0.6, 0.8, 0.0)  # rad, of the motion of each joint


def rows(repeats: int, worlds: Sequence[int]) -> list[Row]:
    """Times a physics step of the suited arm against one of the same model without a suit.

    Raises:
        InputError: MuJoCo Warp is not installed, or a number of worlds is not at least 1.
    """
    for count in worlds:
        at_least("worlds", count, 1)
    once("worlds", worlds)
    return [_compared(repeats, count) for count in worlds]


def _compared(repeats: int, worlds: int) -> Row:
    wp, _ = _warp()
    on_gpu = wp.get_device().is_cuda
    steps = GPU_STEPS if on_gpu else max(1, WORLD_STEPS // worlds)
    return compare(
        f"{worlds} worlds, J-A on 4 joints",
        _stepper(worlds, steps, suited=True),
        "the same without suit",
        _stepper(worlds, steps, suited=False),
        repeats=repeats,
        unit="ns/world-step",
        count=worlds * steps,
    )


def _stepper(worlds: int, steps: int, suited: bool) -> Callable[[], None]:
    """Returns what steps arms that swing; on a GPU one step is a captured graph."""
    wp, mjw = _warp()
    config = ArmConfig()
    mjm = for_warp(config)
    m = mjw.put_model(mjm)
    d = mjw.make_data(mjm, nworld=worlds, nconmax=CONTACTS, njmax=CONSTRAINTS)
    if suited:
        rng, joints = np.random.default_rng(0), resisting_joints(config)
        drawn = {
            joint: [entry.model.scaled(torque=rng.uniform(0.8, 1.2)) for _ in range(VARIED)]
            for joint, entry in joints.items()
        }
        models = {joint: [few[i % VARIED] for i in range(worlds)] for joint, few in drawn.items()}
        starts = {}
        for joint, entry in joints.items():
            few = [model.start(entry.start_angle) for model in drawn[joint]]
            starts[joint] = [few[i % VARIED] for i in range(worlds)]
        attach(m, d, mjm, models, starts=starts)
    m.callback.control = _swing(mjm)
    mjw.step(m, d)  # compiles
    graph = None
    if wp.get_device().is_cuda:
        with wp.ScopedCapture() as capture:
            mjw.step(m, d)
        graph = capture.graph

    def run() -> None:
        for _ in range(steps):
            if graph is None:
                mjw.step(m, d)
            else:
                wp.capture_launch(graph)
        wp.synchronize()

    return run


def _swing(mjm: mujoco.MjModel) -> Callable[[Any, Any], None]:
    """Returns a callback that moves the wearer's joints to and fro, each world at its own rate."""
    wp: Any = _warp()[0]
    middle = wp.array(np.array(MIDDLE), dtype=float)
    stiffness = wp.array(-mjm.actuator_biasprm[: len(MIDDLE), 1], dtype=float)

    @wp.kernel(module="unique", enable_backward=False)
    def swing(
        time: wp.array[float],
        middle: wp.array[float],
        stiffness: wp.array[float],
        ctrl: wp.array2d[float],
    ):
        world, joint = wp.tid()
        rate = 4.0 + 0.1 * float(world % 50)
        angle = middle[joint] + AMPLITUDE * wp.sin(rate * time[world] + float(joint))
        ctrl[world, joint] = stiffness[joint] * angle

    def control(m: Any, d: Any) -> None:
        wp.launch(swing, (d.nworld, len(MIDDLE)), [d.time, middle, stiffness], [d.ctrl])

    return control


def device() -> str:
    """Returns the name of the device, and the versions of Warp and MuJoCo Warp."""
    wp, mjw = _warp()
    found = wp.get_device()
    name = found.name if found.is_cuda else platform.processor() or platform.machine()
    return f"{name}, Warp {wp.__version__}, MuJoCo Warp {mjw.__version__}"


def _warp() -> tuple[Any, Any]:
    try:
        import warp

        warp.config.log_level = warp.LOG_WARNING  # its remarks would be among the JSON
        import mujoco_warp
    except ImportError as error:
        raise InputError(
            f"bench gpu needs MuJoCo Warp ({error}): run pip install 'activesuit[gpu]'"
        ) from error
    return warp, mujoco_warp


def columns(found: Sequence[dict[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Returns header and rows of a table of results: of each device, and its rows."""
    header = ["device", "worlds", "world-steps/s\nwithout suit", "world-steps/s\nwith suit"]
    header += ["time that hysteresis adds", "lowest to highest"]
    return header, [
        [
            one["device"],
            row["what"].partition(" ")[0],
            f"{1e9 / row['reference']:,.0f}",
            f"{1e9 / row['ours']:,.0f}",
            _added(row["ratio"]),
            f"{_added(row['highest'])} to {_added(row['lowest'])}",
        ]
        for one in found
        for row in one["rows"]
    ]


def _added(ratio: float) -> str:
    return f"{100 / ratio - 100:.1f} %"


def report(repeats: int, worlds: Sequence[int], json: bool) -> None:
    """Measures on the first GPU, or on the processor, and prints a table or JSON."""
    found = [row.to_dict() for row in rows(repeats, worlds or WORLDS)]
    result = {"device": device(), "repeats": repeats, "rows": found}
    if json:
        print(to_json(result))
        return
    table(f"steps of many worlds in MuJoCo Warp, medians of {repeats} pairs", *columns([result]))
