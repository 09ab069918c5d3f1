"""Turning the state of an optimizer into JSON-able values and back, bit for bit."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import InputError

GENERATORS = ("PCG64", "PCG64DXSM", "Philox", "SFC64", "MT19937")


def pack(value: Any) -> Any:
    """Returns arrays and numbers as JSON-able ones; infinity, which JSON has not, becomes None."""
    if isinstance(value, Mapping):
        return {key: pack(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        return pack(value.tolist())
    if isinstance(value, list):
        return [pack(part) for part in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def unpack(name: str, value: Any, like: Any) -> Any:
    """Returns a packed value as what it was, of the type and, for arrays, the shape of `like`."""
    if not isinstance(like, np.ndarray):
        return list(value) if isinstance(like, list) else value
    array = np.array(value, dtype=np.float64)
    if array.shape != like.shape:
        raise InputError(
            f"the state's {name} has shape {array.shape} instead of {like.shape}: use a state as "
            "it was saved"
        )
    return np.where(np.isnan(array), np.inf, array)


def parts(
    state: Mapping[str, Any], kind: str, changing: Sequence[str]
) -> tuple[dict[str, Any], Mapping[str, Any], np.random.Generator]:
    """Returns options, changing values and an unseeded generator of the saved kind."""
    _whole(state, ("swarm", "options", "changing", "rng"))
    if state["swarm"] != kind:
        raise InputError(
            f"the state is of a {state['swarm']}, not of a {kind}: call {state['swarm']}.from_state"
        )
    _whole(state["changing"], changing)
    generator = state["rng"].get("bit_generator")
    if generator not in GENERATORS:
        raise InputError(
            f"the state's generator is {generator!r}: use one of {', '.join(GENERATORS)}"
        )
    return (
        dict(state["options"]),
        state["changing"],
        np.random.Generator(getattr(np.random, generator)()),
    )


def _whole(part: Mapping[str, Any], keys: Sequence[str]) -> None:
    for key in keys:
        if key not in part:
            raise InputError(f"the state has no {key!r}: use a state as it was saved")
