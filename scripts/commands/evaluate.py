"""`activesuit evaluate`: compares policies on the same motions."""

from pathlib import Path

from ...checks import at_least
from ...envs.evaluation import Score
from ...envs.evaluation import evaluate as evaluate_policies
from ...envs.making import make_arms
from ...envs.policies import POLICIES, make_policy, needed_options
from ...envs.rollout import Trace
from ..arm_options import USUAL, ArmOptions
from ..options import Env, Force, Gravity, Json, PolicyName, Seed, Suit
from ..output import RunFolder, conclude, progress
from ..reports.motions import cuff_remarks, effort_table, score_table
from ..runs import scene


def evaluate(
    env: Env = None,
    policies: tuple[PolicyName, ...] = tuple(POLICIES),
    episodes: int = 5,
    seed: Seed = 0,
    suit: Suit = None,
    gravity: Gravity = None,
    out: Path | None = None,
    force: Force = False,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Compare assist policies by what the wearer has to do.

    Trained policies are evaluated in the task and with the options that they were trained with.

    Args:
        policies: Names of policies, or folders of training runs, which must have the same options.
        episodes: Number of motions of each policy; all policies get the same motions.
        out: Folder for result.json: a new or an empty one, or that of an earlier evaluate.
    """
    at_least("episodes", episodes, 1)
    at_least("seed", seed, 0)
    chosen = scene(arm, env=env, suit=suit, gravity=gravity, policies=policies)
    for policy in policies:  # reports a mistake before the folder is made
        make_policy(policy, make_arms(chosen.env, 1, **chosen.options, **needed_options(policy)))
    folder = RunFolder(out, "evaluate", force=force) if out else None
    scores = run(chosen.env, policies, episodes, seed, **chosen.options)
    result = {
        "env": chosen.env,
        "episodes": episodes,
        "seed": seed,
        **chosen.options,
        "policies": [score.to_dict() for score in scores],
    }
    where = f"{chosen.place}, {episodes} episodes"
    tables = {
        f"Human torque: {where}": score_table(scores),
        "Effort per episode": effort_table(scores),
    }
    conclude(result, tables, cuff_remarks(scores), folder=folder, json=json)


def run(
    env: str, policies: tuple[str, ...], episodes: int, seed: int, **options: object
) -> list[Score]:
    """Evaluates policies and shows a progress bar."""
    with progress(env, max(1, len(policies) * episodes)) as bar:

        def report(policy: str, traces: list[Trace]) -> None:
            del policy
            bar.advance(len(traces))

        return evaluate_policies(
            env,
            policies,
            episodes=episodes,
            seed=seed,
            on_policy=report,
            **options,  # type: ignore[arg-type]
        )
