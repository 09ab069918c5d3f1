"""From a fit to an entry of a suit file: the place where identification meets the suit format."""

import hashlib
from pathlib import Path
from typing import Any

from ..assets import JOINTS, SuitJoint
from ..assets.suits import Parameters
from ..errors import InputError, unknown_name
from ..hysteresis import Held, JilesAtherton
from ..identification import Curve, Fit, bare


def suit_joint(model: JilesAtherton | Held, **provenance: Any) -> SuitJoint:
    """Returns the suit-file entry of a model; `provenance` fills the other fields."""
    inner = bare(model)
    return SuitJoint(
        model="jiles-atherton",
        parameters=Parameters(Ms=inner.Ms, a=inner.a, alpha=inner.alpha, c=inner.c, k=inner.k),
        angle_unit=inner.angle_unit,
        held=isinstance(model, Held),
        certificate_margin=model.certificate().margin,
        **provenance,
    )


def fitted_joint(fit: Fit, curves: list[Curve], path: Path, note: str = "") -> SuitJoint:
    """Returns the suit-file entry of a fit to the curves in the file `path`."""
    lowest = min(float(curve.angle.min()) for curve in curves)
    highest = max(float(curve.angle.max()) for curve in curves)
    fitted = ", ".join(curve.name for curve in curves if curve.role == "fit")
    return suit_joint(
        fit.model,
        range=(lowest, highest),
        start_angle=float(curves[0].angle[0]),
        grade="identified",
        source=f"{fit.method} fit of {path.name}, curves {fitted}." + (f" {note}" if note else ""),
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
