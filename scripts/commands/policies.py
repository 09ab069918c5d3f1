"""`activesuit list policies`: lists the policies, or says what one needs."""

import os
from typing import Annotated, Any

import tyro

from ...envs.evaluation import BOUNDS
from ...envs.policies import POLICIES
from ...envs.policies.registry import PolicyKind
from ...envs.policies.trained import shipped_policies
from ...errors import unknown_name
from ...text import say
from ..folders import to_json
from ..options import Json, choice
from ..options import policies as known_policies
from ..output import table


def policies(
    name: Annotated[str | None, choice(known_policies, usual="all"), tyro.conf.Positional] = None,
    /,
    json: Json = False,
) -> None:
    """List the policies, with the sensors that they need and their options.

    Args:
        name: Name of a policy, or folder of a training run.
    """
    found = {one: _about(one) for one in (*POLICIES, *shipped_policies())}
    if name is not None and name not in found:
        if not os.path.isdir(name):
            raise unknown_name("policy", name, known_policies())
        found[name] = _about(name)
    found = {one: about for one, about in found.items() if name in (None, one)}
    if json:
        print(to_json(found))
        return
    rows = [
        [one, about["does"], ", ".join(about["sensors"]), ", ".join(about["options"])]
        for one, about in found.items()
    ]
    table("policies", ["name", "does", "sensors", "options"], rows)
    say(
        "Options follow a colon, as in adaptive:suit=emu-like,forgetting=10; every policy takes "
        "guard=true."
    )
    say(f"evaluate also takes the bounds {' and '.join(BOUNDS)}, which know the whole motion.")


def _about(name: str) -> dict[str, Any]:
    kind = PolicyKind.of(name)
    sensors = list(kind.needs["sensors"])
    return {"does": kind.about, "sensors": sensors, "options": list(kind.options)}
