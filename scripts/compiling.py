"""Compiles all kernels once, so that no later use waits for a compilation."""

import inspect
import os
from itertools import pairwise
from typing import Any

import numpy as np

from .. import TASKS
from ..envs.interface.observation import SUITES
from ..envs.making import make_arms, make_env
from ..envs.model import bushing
from ..envs.simulation.compiling import ALONE
from ..hysteresis import Backlash, Dahl, HysteresisModel, Viscoelastic, engine, first_use
from ..hysteresis.engine.native import compile_plugin
from ..identification import Certified, Curve, fit_curves
from ..identification.fits.registry import FITS, fit_model

ENV = "ActiveSuit/ArmTracking-v0"
RANGE = np.array([0.5, 1.5])  # [rad], of the record for all fits
BUDGET = 100  # evaluations of each fit, whose quality does not matter


def compile_kernels() -> int:
    """Compiles all kernels that are not in the cache yet; returns their number."""
    os.environ[ALONE] = "1"  # a second process would not be counted
    listener = first_use.listener
    before = listener.done
    for use in (_plugins, _arms, _models, _fit):
        use()
    return listener.done - before


def _plugins() -> None:
    for name in (*engine.register(), bushing.PLUGIN_NAME):
        compile_plugin(name)


def _arms() -> None:
    """Runs one arm, and rows of arms in each task, on cuffs, and with all faults."""
    env, _ = make_env(ENV)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    sensors = [name for name in SUITES if name != "cuffs"]
    for name in TASKS:
        _move(f"ActiveSuit/{name}-v0")
    _move(ENV, coupling="cuffs")
    _move(ENV, level="faults", sensors=sensors, fatigue=True)


def _move(env: str, **options: Any) -> None:
    rows = make_arms(env, 2, **options)
    rows.reset(seed=0)
    rows.step(rows.action_space.sample())


def _models() -> None:
    """Fits a model of each kind, and calls all functions of the model."""
    curve = _record()
    for name, fit in FITS.items():
        options: dict[str, Any] = (
            {"budget": BUDGET} if "budget" in inspect.signature(fit).parameters else {}
        )
        fitted = fit_model(name, [curve], np.random.default_rng(0), **options)
        _ask(fitted.model)
        _ask(Backlash(model=fitted.model, gap=0.01))
    bare = Dahl(spring=[0.0, 1.0], stiffness=9.0, friction=1.0)
    model = Viscoelastic(model=bare, relaxation_stiffness=1.0, relaxation_time=0.1)
    model.response(curve.angle, time=np.arange(curve.angle.size))


def _ask(model: HysteresisModel) -> None:
    model.certificate()
    model.response(RANGE)
    state, _ = model.step(model.start(RANGE[0]), RANGE[1])
    model.tangent(state, -1.0)
    model.energy(state)
    model.advance(state.memory.copy()[None], RANGE[:1], RANGE[1:])


def _fit() -> None:
    fit_curves([_record()], method=Certified(budget=BUDGET), workers=1)


def _record() -> Curve:
    """Returns a record of two cycles with one loop inside."""
    turns = [*RANGE, 0.9, 1.3, RANGE[0], RANGE[1], RANGE[0]]
    angle = np.concatenate([np.linspace(*way, 12)[:-1] for way in pairwise(turns)])
    torque = 5 * angle + np.sign(np.gradient(angle))
    return Curve(angle, torque - torque[0], "record")
