"""Loads and places that differ between rows: the fields of the model in which they are."""

from dataclasses import replace

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import Array
from ..model import ArmConfig, Payload, compose

BODY = "payload"


class Differing:
    """Gives rows of a batch their own load, and their own gravity.

    Args:
        config: Configuration of the arms, whose load and place rows have until told otherwise.
        loads: Whether rows may have loads of their own.
        places: Whether rows may have a gravity of their own.

    Attributes:
        model: Model of a row, with a body for the load if there may be one.
    """

    def __init__(self, config: ArmConfig, *, loads: bool, places: bool) -> None:
        self._loads, self._places = loads, places
        if not loads:
            self.model = compose(config, drawn=False)
            return
        there = config.payload if config.payload.mass > 0 else Payload(mass=1.0)
        self.model = compose(replace(config, payload=there), drawn=False)
        self._body = self.model.body(BODY).id
        self._grip = self.model.body_pos[self._body] + np.array([0, 0, there.radius])
        model = self.model
        self._put(config.payload, model.body_pos, model.body_mass, model.body_inertia)
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def begin(self, batch: Batch) -> None:
        """Prepares a batch of the model; call it once."""
        self._batch = batch
        if self._loads:
            names = ("body_pos", "body_mass", "body_inertia")
            self._fields = [batch.expand(name) for name in names]
            batch.set_const()
        if self._places:
            self._gravity = batch.expand("opt.gravity")

    def write(self, rows: NDArray[np.int64], load: Array, fall: Array) -> None:
        """Writes loads and gravity of some rows into their models.

        Args:
            rows: The rows, shape (k,).
            load: Mass of the load of every row [kg], shape (n,).
            fall: Acceleration of free fall of every row [m/s²], shape (n,).
        """
        if self._places:
            self._gravity[rows, 2] = -fall[rows]
        if self._loads:
            for row in rows.tolist():
                self._put(Payload(mass=float(load[row])), *(field[row] for field in self._fields))
            self._batch.set_const(rows)

    def _put(self, payload: Payload, pos: NDArray, mass: NDArray, inertia: NDArray) -> None:
        pos[self._body] = self._grip - np.array([0, 0, payload.radius])
        mass[self._body], inertia[self._body] = payload.mass, payload.moments
