"""Wearers, misalignments, loads and places that differ between rows, as fields of the model."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco.batch import MODEL_FIELDS, Batch
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import Suit
from ..model import ArmConfig, Payload, bare_arm, compose
from ..model.cuffs import shift_exoskeleton, strap_again
from ..model.workplace import Edits
from ..person import Person, isometric_strength
from .inverse_dynamics import Chain
from .kinematics import Arm

BODY = "payload"
LOADED = ("body_pos", "body_mass", "body_inertia")


@dataclass(frozen=True, kw_only=True)
class Variety:
    """What may differ between the rows of a simulation, beside their motions.

    `wearers` and `suits` are those that rows may have instead of the configured wearer and suit.
    The other fields say whether the misalignment, the load and the gravity of a row may differ.
    """

    wearers: tuple[Person, ...] = ()
    suits: tuple[Suit, ...] = ()
    misalignments: bool = False
    loads: bool = False
    places: bool = False


class RowModels:
    """Gives rows of a batch their own wearer, misalignment, load and gravity.

    Attributes: model: Model of a row, with a body for the load if there may be a load. persons: The
    wearers. arms: Bare arm of each wearer. chains: Inertial parameters of each bare arm. strengths:
    Isometric strength of each wearer [N·m], shape (2, 4) each.
    """

    def __init__(self, config: ArmConfig, variety: Variety, edits: Edits | None = None) -> None:
        self._variety, self._dressed = variety, dict[int, Chain]()
        loads = variety.loads
        if loads and not config.payload.mass > 0:
            composed = replace(config, payload=Payload(mass=1.0))
        else:
            composed = config
        self.persons = variety.wearers or (config.wearer,)
        arms = [replace(composed, wearer=person) for person in self.persons]
        self._models = [
            compose(arm, drawn=False, other_suits=variety.suits, edits=edits) for arm in arms
        ]
        self.model = self._models[0]
        bare = [bare_arm(arm) for arm in arms]
        self.arms = [
            Arm.of(arm, model.site("hand_grip").pos)
            for arm, model in zip(bare, self._models, strict=True)
        ]
        self.chains = [arm.chain for arm in self.arms]
        self.strengths = [isometric_strength(person) for person in self.persons]
        self._strapped = [mujoco.MjData(model).plugin_state.copy() for model in self._models]
        if not loads:
            return
        self._body, radius = self.model.body(BODY).id, composed.payload.radius
        self._grips = [m.body_pos[self._body] + np.array([0, 0, radius]) for m in self._models]
        for model, grip in zip(self._models, self._grips, strict=True):
            fields = (getattr(model, name) for name in LOADED)
            self._put(config.payload, grip, *fields)
            mujoco.mj_setConst(model, mujoco.MjData(model))

    def dressed(self, wearer: int) -> Chain:
        """Returns the arm of the wearer with a number, with suit and load."""
        if wearer not in self._dressed:
            self._dressed[wearer] = Chain.of(self._models[wearer], dressed=True)
        return self._dressed[wearer]

    def begin(self, batch: Batch) -> None:
        """Prepares a batch of the model; call it once."""
        self._batch, variety = batch, self._variety
        names = set(LOADED) if variety.loads else set()
        names |= {"body_pos"} if variety.misalignments else set()
        for model in self._models[1:]:
            names |= _different(self.model, model)
        self._fields = {name: batch.expand(name) for name in sorted(names)}
        if variety.loads or variety.misalignments:
            batch.set_const()
        if variety.places:
            self._gravity = batch.expand("opt.gravity")

    def write(
        self,
        rows: NDArray[np.int64],
        wearer: NDArray[np.int64],
        misalignment: Array,
        load: Array,
        fall: Array,
    ) -> None:
        """Writes wearer, misalignment, load and gravity of some rows into their models.

        All arrays but `rows` are of all rows: number of the wearer, displacement of the exoskeleton
        [m], shape (n, 3), mass of the load [kg], and acceleration of free fall [m/s²].
        """
        variety = self._variety
        if variety.places:
            self._gravity[rows, 2] = -fall[rows]
        if not self._fields:
            return
        for row in rows.tolist():
            model = self._models[wearer[row]]
            for name, values in self._fields.items():
                values[row] = getattr(model, name)
            if variety.misalignments:
                shift_exoskeleton(model, self._fields["body_pos"][row], misalignment[row])
            if variety.loads:
                self._carry(row, wearer, load)
        if variety.loads or variety.misalignments:
            self._batch.set_const(rows)

    def load(self, rows: NDArray[np.int64], wearer: NDArray[np.int64], load: Array) -> None:
        """Writes new loads at the hands of some rows; see `write`."""
        for row in rows.tolist():
            self._carry(row, wearer, load)
        self._batch.set_const(rows)

    def strap(self, plugin_state: Array, wearer: int, misalignment: Array) -> None:
        """Straps the cuffs of one row on after a reset; they bear no force on a hanging arm."""
        own, first = self._strapped[wearer], self._strapped[0]
        np.copyto(plugin_state, own, where=own != first)
        if misalignment.any():
            strap_again(self.model, plugin_state, misalignment)

    def _carry(self, row: int, wearer: NDArray[np.int64], load: Array) -> None:
        payload, grip = Payload(mass=float(load[row])), self._grips[wearer[row]]
        self._put(payload, grip, *(self._fields[name][row] for name in LOADED))

    def _put(
        self, payload: Payload, grip: Array, pos: NDArray, mass: NDArray, inertia: NDArray
    ) -> None:
        pos[self._body] = grip - np.array([0, 0, payload.radius])
        mass[self._body], inertia[self._body] = payload.mass, payload.moments


def _different(model: mujoco.MjModel, other: mujoco.MjModel) -> set[str]:
    """Returns the names of the fields in which two models of the same layout differ."""
    found = set()
    for name in MODEL_FIELDS:
        here = getattr(model, name, None)
        if isinstance(here, np.ndarray) and not np.array_equal(here, getattr(other, name)):
            found.add(name)
    return found
