"""`activesuit validate`: scores a controller whose model of the suit is not the simulated one."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import tyro

from ...assets import Suit, load_suit
from ...checks import at_least
from ...envs.evaluation import FIRST_SEED, Evaluation
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.making import make_env
from ...envs.model import ASSISTED
from ..arm_options import USUAL, ArmOptions
from ..options import SUIT, Env, Force, Json, choice, gravity_option, suits
from ..output import RunFolder, conclude
from ..reports.motions import cuff_remarks, interval_text, score_table
from ..runs import scene
from .evaluate import run

GRAVITY = "microgravity"
TRUE = "true model"


def validate(
    suit: Annotated[str, choice(suits), tyro.conf.Positional],
    /,
    plant: Annotated[str, choice(suits)] = SUIT,
    env: Env = None,
    gravity: Annotated[str | None, gravity_option(GRAVITY)] = None,
    episodes: int = 20,
    seed: int = FIRST_SEED,
    out: Path | None = None,
    force: Force = False,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Validate an identified suit model in closed loop.

    The controller cancels the torque that its model of the suit predicts, while the simulated arm
    wears the suit PLANT. The score compares the wearer's relief with that by the same controller
    with the true model of PLANT. By default there is no gravity, so that only the suit's torque
    remains.

    Args:
        suit: Suit that the controller believes: name of a shipped one, or path of a suit file.
        plant: Suit that is simulated: name of a shipped one, or path of a suit file.
        episodes: Number of motions of each policy, at least 8; all policies get the same motions.
        seed: Seed of the first motion.
        out: Folder for result.json: a new or an empty one, or that of an earlier validate.
    """
    believed, worn = load_suit(suit), load_suit(plant)
    at_least("episodes", episodes, FEWEST_MOTIONS)
    at_least("seed", seed, 0)
    chosen = scene(arm, env=env, suit=plant, gravity=gravity, usual={"gravity": GRAVITY})
    make_env(chosen.env, **chosen.options)[0].close()
    folder = RunFolder(out, "validate", force=force) if out else None
    found = run(
        chosen.env,
        {"none": "none", "feedforward": {"name": "feedforward", "suit": suit}, TRUE: "feedforward"},
        episodes,
        seed,
        naive=False,
        **chosen.options,
    )
    scores, share = list(found.scores.values()), _share_by_joint(found, worn)
    lacking = {
        "feedforward": [joint for joint in ASSISTED if joint not in believed.joints],
        TRUE: [joint for joint in ASSISTED if joint not in worn.joints],
    }
    result = {
        "believed_suit": suit,
        "plant": plant,
        "env": chosen.env,
        "episodes": episodes,
        "seed": seed,
        **chosen.options,
        "share_of_true_model_by_joint": share,
        "believed_suit_lacks": lacking["feedforward"],
        "plant_lacks": lacking[TRUE],
        **found.to_dict(),
    }
    place = f"{chosen.env}, {chosen.options['gravity']}"
    title = f"Human torque: {place}; believes {suit}, wears {plant}"
    remarks = [*_overall(found), *_remarks(share, lacking, suit, plant), *cuff_remarks(scores)]
    tables = {title: score_table(scores, found)}
    conclude(result, tables, remarks, folder=folder, json=json)


def _overall(found: Evaluation) -> Iterator[str]:
    relief, share = found.relief("feedforward"), found.share_of_bound("feedforward", TRUE)
    if relief is None or share is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."
        return
    yield (
        f"feed-forward gives back {interval_text(relief)} of what the suit costs, "
        f"{interval_text(share)} of what the true model does"
    )


def _share_by_joint(found: Evaluation, worn: Suit) -> dict[str, float]:
    """Returns the believed model's reduction of torque over the true one's, by assisted joint.

    It is NaN where the true model reduces nothing.
    """
    off, forward, true = (found.scores[n].human_rms for n in ("none", "feedforward", TRUE))
    return {
        joint: (off[joint] - forward[joint]) / (off[joint] - true[joint])
        if off[joint] > true[joint]
        else math.nan
        for joint in ASSISTED
        if joint in worn.joints
    }


def _remarks(
    share: dict[str, float], lacking: dict[str, list[str]], suit: str, plant: str
) -> Iterator[str]:
    for joint, value in share.items():
        if joint in lacking["feedforward"]:
            yield f"{joint}: not assisted, because {suit} has no such joint"
        elif math.isnan(value):
            yield f"{joint}: the true model reduces nothing to compare with"
        else:
            yield f"{joint}: {value:.1%} of the true model's reduction"
    for joint in lacking[TRUE]:
        yield f"{joint}: nothing to assist, because {plant} has no such joint"
