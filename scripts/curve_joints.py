"""Which joint a file of measured curves belongs to."""

from pathlib import Path

from ..assets import JOINTS
from ..errors import InputError, unknown_name


def joint_of(path: Path, joint: str | None) -> str:
    """Returns the joint that a curve file belongs to: `joint`, or what the file name says."""
    if joint is not None:
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
