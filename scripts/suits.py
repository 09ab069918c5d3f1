"""`activesuit suits`: what suits there are, and what is in one."""

from dataclasses import asdict
from typing import Annotated

import tyro

from ..assets import SuitJoint, load_suit, suit_names
from ..envs.composition import joint_models
from ..hysteresis import Held, JilesAtherton, PoleError
from ..identification import bare
from .output import table, to_json


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
    models = joint_models(loaded)
    certificates = {joint: model.certificate() for joint, model in models.items()}
    if json:
        content = loaded.model_dump()
        for joint, certificate in certificates.items():
            content["joints"][joint]["certificate"] = asdict(certificate)
        print(to_json(content))
        return
    print(f"{loaded.name}: {loaded.description}\n")
    if not models:
        print("It resists no joint.")
        return
    columns = [_column(loaded.joints[joint], model) for joint, model in models.items()]
    names = [joint.replace("_", "\n") for joint in models]
    rows = ([quantity, *(column[quantity] for column in columns)] for quantity in columns[0])
    table("models", ["", *names], rows, left=1)
    for joint, entry in loaded.joints.items():
        print(f"{joint}: {entry.source}")


def _column(entry: SuitJoint, model: JilesAtherton | Held) -> dict[str, str]:
    certificate, degrees = model.certificate(), bare(model).in_unit("deg")
    low, high = entry.range
    try:
        torque = f"{model.response([entry.start_angle, high])[-1]:.2f}"
    except PoleError:
        torque = "infinite"
    return {
        "grade": entry.grade,
        "Ms [N·m]": f"{degrees.Ms:.4g}",
        "a [deg]": f"{degrees.a:.4g}",
        "alpha [deg/N·m]": f"{degrees.alpha:.4g}",
        "c": f"{degrees.c:.4g}",
        "k [deg]": f"{degrees.k:.4g}",
        "range [rad]": f"{low:.2f} .. {high:.2f}",
        "outside": "held" if entry.held else "model",
        "torque at the end [N·m]": torque,
        "certificate margin": f"{certificate.margin:.3f}",
        "safe to simulate": "yes" if certificate.certified and certificate.dissipative else "NO",
    }
