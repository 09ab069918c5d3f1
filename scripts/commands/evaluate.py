"""`activesuit evaluate`: compares policies on the same motions."""

from pathlib import Path
from typing import Annotated

from ...checks import at_least
from ...envs.evaluation import Score, Trace, make_env
from ...envs.evaluation import evaluate as evaluate_policies
from ...envs.policies import POLICIES, make_policy
from ...envs.policies.trained import training_config
from ..arm_options import USUAL, ArmOptions
from ..options import Gravity, Json, PolicyName, Seed, SuitName, choice, environments
from ..output import RunFolder, conclude, progress
from ..reports.motions import cuff_remarks, effort_table, score_table


def evaluate(
    env: Annotated[str | None, choice(environments)] = None,
    policies: tuple[PolicyName, ...] = tuple(POLICIES),
    episodes: int = 5,
    seed: Seed = 0,
    suit: SuitName = "mock-suit",
    gravity: Gravity = "earth",
    out: Path | None = None,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Compare assist policies by what the wearer has to do.

    Args:
        env: Id of the environment to simulate; by default the one that the first trained policy
            was trained on, else ActiveSuit/ArmTracking-v0.
        policies: Names of policies, or folders of training runs.
        episodes: Number of motions of each policy; all policies get the same motions.
        out: Folder for result.json.
    """
    env = env or _trained_on(policies) or "ActiveSuit/ArmTracking-v0"
    options = arm.config(suit, gravity)
    at_least("episodes", episodes, 1)
    at_least("seed", seed, 0)
    made, simulated = make_env(env, **options)
    for policy in policies:  # reports a mistake before the folder is made
        make_policy(policy, simulated)
    made.close()
    folder = RunFolder(out) if out else None
    scores = run(env, policies, episodes, seed, **options)
    result = {
        "env": env,
        "episodes": episodes,
        "seed": seed,
        **options,
        "policies": [score.to_dict() for score in scores],
    }
    where = f"{env}, {gravity}, {suit}, {episodes} episodes"
    tables = {
        f"Human torque: {where}": score_table(scores),
        "Effort per episode": effort_table(scores),
    }
    conclude(result, tables, cuff_remarks(scores), folder=folder, json=json)


def _trained_on(policies: tuple[str, ...]) -> str | None:
    """Returns the environment of the first policy that is the folder of a training run."""
    for name in policies:
        if name not in POLICIES and Path(name).is_dir():
            return training_config(name)["env"]
    return None


def run(
    env: str, policies: tuple[str, ...], episodes: int, seed: int, **options: object
) -> list[Score]:
    """Evaluates policies and shows a progress bar."""
    with progress(env, max(1, len(policies) * episodes)) as bar:

        def report(policy: str, episode: int, trace: Trace) -> None:
            del policy, episode, trace
            bar.advance()

        return evaluate_policies(
            env,
            policies,
            episodes=episodes,
            seed=seed,
            on_episode=report,
            **options,  # type: ignore[arg-type]
        )
