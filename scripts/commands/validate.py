"""`activesuit validate`: scores a controller whose model of the suit is not the simulated one."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import tyro

from ...assets import load_suit
from ...checks import at_least
from ...envs.evaluation import share_of_oracle
from ...envs.making import make_env
from ...envs.model import ASSISTED
from ..arm_options import USUAL, ArmOptions
from ..options import SUIT, Env, Force, Json, Seed, choice, gravity_option, suits
from ..output import RunFolder, conclude
from ..reports.motions import cuff_remarks, score_table
from ..runs import scene
from .evaluate import run

GRAVITY = "microgravity"


def validate(
    suit: Annotated[str, choice(suits), tyro.conf.Positional],
    /,
    plant: Annotated[str, choice(suits)] = SUIT,
    env: Env = None,
    gravity: Annotated[str | None, gravity_option(GRAVITY)] = None,
    episodes: int = 5,
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
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
        out: Folder for result.json: a new or an empty one, or that of an earlier validate.
    """
    believed, worn = load_suit(suit), load_suit(plant)
    at_least("episodes", episodes, 1)
    at_least("seed", seed, 0)
    chosen = scene(arm, env=env, suit=plant, gravity=gravity, usual={"gravity": GRAVITY})
    make_env(chosen.env, **chosen.options)[0].close()
    folder = RunFolder(out, "validate", force=force) if out else None
    scores = run(
        chosen.env,
        ("none", "feedforward", "oracle"),
        episodes,
        seed,
        believed_suit=suit,
        **chosen.options,
    )
    share = share_of_oracle(scores, worn)
    lacking = {
        "feedforward": [joint for joint in ASSISTED if joint not in believed.joints],
        "oracle": [joint for joint in ASSISTED if joint not in worn.joints],
    }
    result = {
        "believed_suit": suit,
        "plant": plant,
        "env": chosen.env,
        "episodes": episodes,
        "seed": seed,
        **chosen.options,
        "share_of_oracle": share,
        "believed_suit_lacks": lacking["feedforward"],
        "plant_lacks": lacking["oracle"],
        "policies": [score.to_dict() for score in scores],
    }
    place = f"{chosen.env}, {chosen.options['gravity']}"
    title = f"Human torque: {place}; believes {suit}, wears {plant}"
    remarks = [*_remarks(share, lacking, suit, plant), *cuff_remarks(scores)]
    tables = {title: score_table(scores, lacking)}
    conclude(result, tables, remarks, folder=folder, json=json)


def _remarks(
    share: dict[str, float], lacking: dict[str, list[str]], suit: str, plant: str
) -> Iterator[str]:
    for joint, value in share.items():
        if joint in lacking["feedforward"]:
            yield f"{joint}: not assisted, because {suit} has no such joint"
        elif math.isnan(value):
            yield f"{joint}: the oracle reduces nothing that the reduction could be compared with"
        else:
            yield f"{joint}: {value:.1%} of the oracle's reduction"
    for joint in lacking["oracle"]:
        yield f"{joint}: nothing to assist, because {plant} has no such joint"
