"""Angles behind play between encoder and joint, and behind a gap in the transmission."""

import numpy as np

from ..arrays import Array
from .curves import Curve, noise_floor

CERTAIN = 4.0  # deviations of the noise, above which a torque shows the face in contact


def played(angle: Array, gap: float) -> Array:
    """Returns the angle behind a play of a gap [rad], which follows once the gap is taken up."""
    found, here = np.empty_like(angle), angle[0]
    for i, ahead in enumerate(angle):
        here = min(max(here, ahead - gap), ahead)
        found[i] = here
    return found


def suit_angles(curve: Curve, gap: float) -> Array:
    """Returns the angles of the suit's side of a gap [rad], shape (n,)."""
    side = np.where(
        np.abs(curve.torque) > CERTAIN * noise_floor([curve]), np.sign(curve.torque), 0.0
    )
    end, found = float(curve.angle[0]), np.empty_like(curve.angle)
    for i, (angle, face) in enumerate(zip(curve.angle.tolist(), side.tolist(), strict=True)):
        low, high = angle - gap / 2, angle + gap / 2
        end = angle - face * gap / 2 if face else min(max(end, low), high)
        found[i] = end
    return found
