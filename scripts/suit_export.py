"""From a fit to an entry of a suit file: the place where identification meets the suit format."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..assets import JOINTS, SuitJoint
from ..errors import InputError, unknown_name
from ..hysteresis import HysteresisModel
from ..identification import Curve, Fit


def suit_joint(model: HysteresisModel, **provenance: Any) -> SuitJoint:
    """Returns the suit-file entry of a model; `provenance` fills the other fields."""
    margin = model.certificate().margin
    return SuitJoint(model=model, certificate_margin=margin, **provenance)


def fitted_joint(
    fit: Fit,
    curves: Sequence[Curve],
    path: Path,
    note: str = "",
    samples: Sequence[HysteresisModel] = (),
) -> SuitJoint:
    """Returns the suit-file entry of a fit to the curves in the file `path`."""
    lowest = min(float(curve.angle.min()) for curve in curves)
    highest = max(float(curve.angle.max()) for curve in curves)
    fitted = [curve for curve in curves if curve.role == "fit"]
    names = ", ".join(curve.name for curve in fitted)
    start_torque = fit.initial_torque
    if isinstance(start_torque, str):  # "measured"
        start_torque = float(np.mean([curve.torque[0] for curve in fitted]))
    return suit_joint(
        fit.model,
        samples=tuple(samples),
        range=(lowest, highest),
        start_angle=float(curves[0].angle[0]),
        start_torque=start_torque,
        grade="identified",
        source=f"{fit.method} fit of {path.name}, curves {names}." + (f" {note}" if note else ""),
        data_sha256=hashlib.sha256(path.read_bytes()).hexdigest(),
        fit_nrmse=fit.nrmse,
    )


def joint_of(path: Path, joint: str | None) -> str:
    """Returns the joint that a curve file belongs to: `joint`, or what the file name says.

    Raises:
        InputError: `joint` is none of the arm's, or None and the file name names no joint.
    """
    if joint:
        if joint not in JOINTS:
            raise unknown_name("joint", joint, JOINTS)
        return joint
    for name in (path.stem, f"{path.stem}_flexion"):
        if name in JOINTS:
            return name
    raise InputError(
        f"cannot tell which joint {path.name!r} was measured on: give --joint with one of "
        f"{', '.join(JOINTS)}"
    )
