"""The condition under which a model may enter a simulation or a device."""

from .certificate import UncertifiedModelError
from .jiles_atherton import PARAMETERS, JilesAtherton, nearest_certified
from .protocol import HysteresisModel, State


def require_certificate(model: HysteresisModel, start: State, joint: str) -> None:
    """Checks that no motion that begins in `start` makes the torque infinite or extracts energy.

    Raises:
        UncertifiedModelError: The model has no certificate, or the start is outside of it.
    """
    certificate = model.certificate()
    if not (certificate.certified and certificate.dissipative):
        near, hint = None, "use other parameters"
        if isinstance(model, JilesAtherton):
            near, change = nearest_certified(model)
            values = ", ".join(f"{name}={getattr(near, name):.6g}" for name in PARAMETERS)
            hint = f"use the nearest certified model ({100 * change:.2g} % off): {values}"
        raise UncertifiedModelError(
            f"{joint}: the certificate margin is {certificate.margin:.3g} (above 0 needed) and "
            f"dissipative is {certificate.dissipative}; {hint}, or allow_uncertified=True "
            "(--allow-uncertified)",
            margin=certificate.margin,
            nearest=near,
        )
    if not model.start_is_certified(start):
        raise UncertifiedModelError(
            f"the start of joint {joint!r} at {start.angle:.4g} rad, {start.torque:.4g} N·m lies "
            f"outside the certificate, within {certificate.memory_bound:.3g} N·m of the torque at "
            "rest: start nearer to that torque, or allow_uncertified=True",
            margin=certificate.margin,
        )
