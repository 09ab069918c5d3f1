"""`activesuit validate`: how well a controller that believes one suit cancels another."""

from pathlib import Path
from typing import Annotated

import tyro

from ...assets import load_suit
from ...envs.evaluation import make_env, share_of_oracle
from ..options import USUAL, ArmOptions
from ..output import RunFolder, conclude
from ..reports.tables import cuff_remarks, score_table
from .evaluate import run


def validate(
    suit: Annotated[str, tyro.conf.Positional],
    /,
    plant: str = "mock-suit",
    env: str = "ActiveSuit/ArmTracking-v0",
    gravity: str = "microgravity",
    episodes: int = 5,
    seed: int = 0,
    out: Path | None = None,
    arm: ArmOptions = USUAL,
    json: bool = False,
) -> None:
    """Validate an identified suit model in closed loop.

    The controller's feed-forward believes SUIT, the simulation wears PLANT. The score is how much
    of the oracle's relief, which knows the plant's true torque, the model achieves.

    Args:
        suit: the identified suit: a name, or a suit file.
        plant: the simulated suit: a name, or a suit file.
        env: ActiveSuit/ShoulderFlexion-v0, ElbowFlexion-v0 or ArmTracking-v0.
        gravity: earth, mars, moon or microgravity; without gravity the suit is what remains.
        episodes: motions per policy.
        seed: fixes the motions.
        out: folder for result.json.
        arm: wearer, coupling and load.
        json: print the result as JSON.
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
