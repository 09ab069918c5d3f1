"""`activesuit suits`: what suits there are, and what is in one."""

from dataclasses import asdict
from typing import Annotated

import tyro

from ..assets import SuitJoint, load_suit, suit_names
from ..hysteresis import PoleError
from .output import table, to_json
from .tables import parameter_table


def suits(
    suit: Annotated[str | None, tyro.conf.Positional] = None,
    /,
    json: bool = False,
) -> None:
    """List the shipped suits, or show and check one.

    Args:
        suit: name of a shipped suit, or a suit file.
        json: print the result as JSON.
    """
    if suit is None:
        listed = {name: load_suit(name).description for name in suit_names()}
        if json:
            print(to_json(listed))
        else:
            table("suits", ["name", "description"], listed.items())
        return
    loaded = load_suit(suit)
    if json:
        content = loaded.model_dump()
        for joint, entry in loaded.joints.items():
            content["joints"][joint]["certificate"] = asdict(entry.model.certificate())
        print(to_json(content))
        return
    print(f"{loaded.name}: {loaded.description}\n")
    if not loaded.joints:
        print("It resists no joint.")
        return
    names = {joint: joint.replace("_", "\n") for joint in loaded.joints}
    header, rows = parameter_table({names[j]: entry.model for j, entry in loaded.joints.items()})
    columns = [_column(entry) for entry in loaded.joints.values()]
    rows += [[quantity, *(column[quantity] for column in columns)] for quantity in columns[0]]
    table("models", header, rows, left=1)
    for joint, entry in loaded.joints.items():
        print(f"{joint}: {entry.source}")


def _column(entry: SuitJoint) -> dict[str, str]:
    certificate = entry.model.certificate()
    low, high = entry.range
    try:
        torque = entry.model.response([entry.start_angle, high], entry.start_torque)[-1]
    except PoleError:
        torque = float("inf")
    return {
        "grade": entry.grade,
        "start [rad, N·m]": f"{entry.start_angle:.2f}, {entry.start_torque:.2f}",
        "range [rad]": f"{low:.2f} .. {high:.2f}",
        "torque at its end [N·m]": f"{torque:.2f}",
        "certificate margin": f"{certificate.margin:.3f}",
        "safe to simulate": "yes" if certificate.certified and certificate.dissipative else "NO",
        "samples": str(len(entry.samples)),
    }
