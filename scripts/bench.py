"""`activesuit bench`: speed as ratios of paired medians measured in one run."""

import platform
import statistics
import time
from collections.abc import Callable
from typing import Annotated, Any, Literal

import mujoco
import numpy as np
import tyro
from numba import njit

from ..assets import SCENE, curves_path, load_suit
from ..envs.composition import joint_models
from ..envs.evaluation import make_env
from ..errors import at_least
from ..hysteresis._langevin import langevin
from ..hysteresis.engine import attach
from ..identification import certified_fit, identify, load_curves
from .make_assets import PUBLISHED
from .output import table, to_json

Topic = Literal["all", "hysteresis", "engine", "env", "identify"]


def bench(
    topic: Annotated[Topic, tyro.conf.Positional] = "all",
    /,
    repeats: int = 9,
    json: bool = False,
) -> None:
    """Measure speed; each row compares two things in turn in this very run.

    Args:
        topic: hysteresis, engine, env, identify, or all.
        repeats: pairs of measurements per row.
        json: print the result as JSON.
    """
    at_least("repeats", repeats, 1)
    topics: dict[str, Callable[[int], dict[str, Any]]] = {
        "hysteresis": _hysteresis,
        "engine": _engine,
        "env": _env,
        "identify": _identify,
    }
    rows = [run(repeats) for name, run in topics.items() if topic in (name, "all")]
    machine = f"{platform.processor() or platform.machine()}, MuJoCo {mujoco.__version__}"
    if json:
        print(to_json({"machine": machine, "repeats": repeats, "rows": rows}))
        return
    table(
        f"medians of {repeats} pairs; {machine}",
        ["ours\nagainst", "time", "ratio", "lowest\nhighest", "target"],
        (
            [
                f"{row['what']}\n{row['against']}",
                f"{row['ours']:.3g} {row['unit']}\n{row['reference']:.3g} {row['unit']}",
                f"{row['ratio']:.2f}",
                f"{row['lowest']:.2f}\n{row['highest']:.2f}",
                f">= {row['target']} {'met' if row['met'] else 'NOT met'}"
                if row["target"]
                else "-",
            ]
            for row in rows
        ),
        left=1,
    )


def _paired(ours: Callable[[], Any], reference: Callable[[], Any], repeats: int, count: int = 1):
    """Returns median seconds per count of both, and the pairwise ratios reference / ours."""
    ours()
    reference()
    pairs = [(_seconds(ours), _seconds(reference)) for _ in range(repeats)]
    ratios = [b / a for a, b in pairs]
    return (
        statistics.median(a for a, _ in pairs) / count,
        statistics.median(b for _, b in pairs) / count,
        ratios,
    )


def _seconds(work: Callable[[], Any]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _row(
    what: str, against: str, target: float | None, unit: str, scale: float, measured
) -> dict[str, Any]:
    ours, reference, ratios = measured
    return {
        "what": what,
        "against": against,
        "unit": unit,
        "ours": ours * scale,
        "reference": reference * scale,
        "ratio": statistics.median(ratios),
        "met": target is None or statistics.median(ratios) >= target,
        "lowest": min(ratios),
        "highest": max(ratios),
        "target": target,
    }


@njit(error_model="numpy")
def _rk4_response(H, M0, Ms, a, alpha, c, k, M):
    """The usual way to integrate eq. (4): one classical Runge-Kutta step in H per sample."""

    def slope(H, M, delta):
        L, dL, _ = langevin((H + alpha * M) / a)
        f = Ms * L - M + c * delta * k * Ms * dL / a
        return f / (delta * k - alpha * f)

    M[0] = M0
    for i in range(1, H.size):
        h, m, x = H[i] - H[i - 1], M[i - 1], H[i - 1]
        if h != 0:
            delta = 1.0 if h > 0 else -1.0
            k1 = slope(x, m, delta)
            k2 = slope(x + h / 2, m + h / 2 * k1, delta)
            k3 = slope(x + h / 2, m + h / 2 * k2, delta)
            k4 = slope(x + h, m + h * k3, delta)
            m += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        M[i] = m


def _hysteresis(repeats: int) -> dict[str, Any]:
    up = np.linspace(0.52, 1.57, 450)
    angle = np.tile(np.concatenate([up, up[::-1]]), 100)
    torque = np.empty_like(angle)
    arguments = PUBLISHED["elbow"].kernel_arguments[:5]
    measured = _paired(
        lambda: PUBLISHED["elbow"].response(angle),
        lambda: _rk4_response(angle, 0.0, *arguments, torque),
        repeats,
        angle.size,
    )
    return _row("J-A response", "scalar RK4 in H", 4.0, "ns/sample", 1e9, measured)


def _engine(repeats: int, steps: int = 5000) -> dict[str, Any]:
    plain = mujoco.MjSpec.from_file(str(SCENE))
    suited = mujoco.MjSpec.from_file(str(SCENE))
    for joint, model in joint_models(load_suit("mock-suit")).items():
        attach(suited, joint, model, sensors=False)

    def stepper(spec: mujoco.MjSpec) -> Callable[[], None]:
        model = spec.compile()
        data = mujoco.MjData(model)
        reach = model.key("reach").ctrl

        def run() -> None:
            mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
            data.ctrl[:] = reach
            mujoco.mj_step(model, data, steps)

        return run

    measured = _paired(stepper(suited), stepper(plain), repeats, steps)
    return _row("mj_step, suit on 4 joints", "without suit", 0.90, "us/step", 1e6, measured)


def _env(repeats: int, steps: int = 500) -> dict[str, Any]:
    env, arm = make_env("ActiveSuit/ArmTracking-v0")
    env.reset(seed=0)
    action = np.zeros(2, dtype=np.float32)
    data = mujoco.MjData(arm.model)
    mujoco.mj_resetDataKeyframe(arm.model, data, 0)

    def ours() -> None:
        for _ in range(steps):
            env.step(action)

    def raw() -> None:
        for _ in range(steps):
            mujoco.mj_step(arm.model, data, arm.substeps)

    measured = _paired(ours, raw, repeats, steps)
    return _row("env.step", "raw mj_step of a frame", 0.50, "us/step", 1e6, measured)


def _identify(repeats: int) -> dict[str, Any]:
    curves = [c for c in load_curves(curves_path("elbow")) if c.role == "fit"]

    def swarm() -> None:

        identify(curves, method="sa-pso", trials=1, workers=1)

    measured = _paired(lambda: certified_fit(curves, rng=0), swarm, repeats)
    return _row("certified fit, elbow", "one SA-PSO trial", None, "ms", 1e3, measured)
