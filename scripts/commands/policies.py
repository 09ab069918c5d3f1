"""`activesuit list policies`: lists the policies, or says what one needs."""

import os
from typing import Annotated, Any

import tyro

from ...envs.evaluation import BOUNDS
from ...envs.policies import POLICIES
from ...envs.policies.build import options_of
from ...envs.policies.network import read_card
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
    found = {one: _about(maker) for one, maker in POLICIES.items()}
    found |= {one: _trained(folder) for one, folder in shipped_policies().items()}
    if name is not None and name not in found:
        if not os.path.isdir(name):
            raise unknown_name("policy", name, known_policies())
        found[name] = _trained(name)
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


def _about(maker: Any) -> dict[str, Any]:
    return {
        "does": (maker.__doc__ or "").partition("\n\n")[0].strip(),
        "sensors": list(maker.sensors),
        "options": list(options_of(maker)),
    }


def _trained(folder: str) -> dict[str, Any]:
    card = read_card(folder)
    return {"does": card.summary or "", "sensors": card.observation["sensors"], "options": []}
