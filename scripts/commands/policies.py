"""`activesuit policies`: lists the policies."""

from typing import Any

from ...envs.evaluation import BOUNDS
from ...envs.policies import POLICIES
from ...envs.policies.build import options_of
from ...envs.policies.network import read_card
from ...envs.policies.trained import shipped_policies
from ..options import Json
from ..output import say, table, to_json


def policies(json: Json = False) -> None:
    """List the policies, with the sensors that they need and their options."""
    found = {name: _about(maker) for name, maker in POLICIES.items()}
    found |= {name: _trained(folder) for name, folder in shipped_policies().items()}
    if json:
        print(to_json(found))
        return
    rows = [
        [name, one["does"], ", ".join(one["sensors"]), ", ".join(one["options"])]
        for name, one in found.items()
    ]
    table("policies", ["name", "does", "sensors", "options"], rows, left=4)
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
    return {
        "does": card.summary or "",
        "sensors": card.observation["sensors"],
        "options": [],
    }
