"""`activesuit validate`: scores a controller whose model of the suit is not the simulated one."""

from pathlib import Path
from typing import Annotated

import tyro

from ...assets import load_suit
from ...envs.evaluation import make_env, share_of_oracle
from ..arm_options import USUAL, ArmOptions
from ..options import Env, Gravity, Json, Seed, choice, suits
from ..output import RunFolder, conclude
from ..reports.motions import cuff_remarks, score_table
from .evaluate import run


def validate(
    suit: Annotated[str, choice(suits), tyro.conf.Positional],
    /,
    plant: Annotated[str, choice(suits)] = "mock-suit",
    env: Env = "ActiveSuit/ArmTracking-v0",
    gravity: Gravity = "microgravity",
    episodes: int = 5,
    seed: Seed = 0,
    out: Path | None = None,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Validate an identified suit model in closed loop.

    The controller cancels the torque that its model of the suit predicts, while the simulated arm
    wears the suit PLANT. The score compares the wearer's relief with that of the oracle, a policy
    that knows the true torque of PLANT. By default there is no gravity, so that only the suit's
    torque remains.

    Args:
        suit: Suit that the controller believes: name of a shipped one, or path of a suit file.
        plant: Suit that is simulated: name of a shipped one, or path of a suit file.
        episodes: Number of motions of each policy; all policies get the same motions.
        out: Folder for result.json.
    """
    load_suit(suit)
    worn = load_suit(plant)
    options = arm.config(plant, gravity)
    make_env(env, **options)[0].close()
    folder = RunFolder(out) if out else None
    scores = run(
        env,
        ("none", "feedforward", "oracle"),
        episodes,
        seed,
        believed_suit=suit,
        **options,
    )
    share = share_of_oracle(scores, worn)
    result = {
        "believed_suit": suit,
        "plant": plant,
        "env": env,
        "episodes": episodes,
        "seed": seed,
        **options,
        "share_of_oracle": share,
        "policies": [score.to_dict() for score in scores],
    }
    title = f"Human torque: {env}, {gravity}; believes {suit}, wears {plant}"
    reached = [f"{joint}: {value:.1%} of the oracle's reduction" for joint, value in share.items()]
    remarks = [*reached, *cuff_remarks(scores)]
    conclude(result, {title: score_table(scores)}, remarks, folder=folder, json=json)
