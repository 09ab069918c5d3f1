"""`activesuit policies`: lists the policies."""

from typing import Any

from ...envs.policies import POLICIES
from ...envs.policies.build import options_of
from ..options import Json
from ..output import table, to_json


def policies(json: Json = False) -> None:
    """List the policies, with the sensors that they need and their options."""
    found = {name: _about(maker) for name, maker in POLICIES.items()}
    if json:
        print(to_json(found))
        return
    rows = [
        [name, one["does"], ", ".join(one["sensors"]), ", ".join(one["options"])]
        for name, one in found.items()
    ]
    table("policies", ["name", "does", "sensors", "options"], rows, left=4)


def _about(maker: Any) -> dict[str, Any]:
    return {
        "does": (maker.__doc__ or "").partition("\n\n")[0].strip(),
        "sensors": list(maker.sensors),
        "options": list(options_of(maker)),
    }
