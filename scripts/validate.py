"""`activesuit validate`: how well a controller that believes one suit cancels another."""

from pathlib import Path
from typing import Annotated

import tyro

from ..assets import load_suit
from ..envs.evaluation import make_env, share_of_oracle
from .evaluate import run
from .output import RunFolder, conclude
from .tables import score_table


def validate(
    suit: Annotated[str, tyro.conf.Positional],
    /,
    plant: str = "mock-suit",
    env: str = "ActiveSuit/ArmTracking-v0",
    gravity: str = "microgravity",
    episodes: int = 5,
    seed: int = 0,
    out: Path | None = None,
    allow_uncertified: bool = False,
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
        allow_uncertified: accept a plant whose torque could become infinite in some motion.
        json: print the result as JSON.
    """
    load_suit(suit)
    worn = load_suit(plant)
    make_env(env, suit=plant, gravity=gravity, allow_uncertified=allow_uncertified)[0].close()
    folder = RunFolder(out) if out else None
    scores = run(
        env,
        ("none", "feedforward", "oracle"),
        episodes,
        seed,
        believed_suit=suit,
        suit=plant,
        gravity=gravity,
        allow_uncertified=allow_uncertified,
    )
    share = share_of_oracle(scores, worn)
    result = {
        "believed_suit": suit,
        "plant": plant,
        "env": env,
        "gravity": gravity,
        "episodes": episodes,
        "seed": seed,
        "share_of_oracle": share,
        "policies": [score.to_dict() for score in scores],
    }
    title = f"Human torque: {env}, {gravity}; believes {suit}, wears {plant}"
    reached = [f"{joint}: {value:.1%} of the oracle's reduction" for joint, value in share.items()]
    conclude(result, title, score_table(scores), reached, folder=folder, json=json)
