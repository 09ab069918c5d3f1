"""`activesuit evaluate`: policies side by side on the same motions."""

from pathlib import Path

from ..envs.evaluation import Score, Trace, make_env
from ..envs.evaluation import evaluate as evaluate_policies
from ..envs.policies import POLICIES
from ..envs.policies.trained import training_config
from .output import RunFolder, conclude, progress
from .tables import score_table


def evaluate(
    env: str | None = None,
    policies: tuple[str, ...] = POLICIES,
    episodes: int = 5,
    seed: int = 0,
    suit: str = "mock-suit",
    gravity: str = "earth",
    out: Path | None = None,
    allow_uncertified: bool = False,
    json: bool = False,
) -> None:
    """Compare assist policies by what the wearer has to do.

    Args:
        env: ActiveSuit/ShoulderFlexion-v0, ElbowFlexion-v0 or ArmTracking-v0; by default what the
            first trained policy was trained on, else ArmTracking.
        policies: none, gravity, feedforward, oracle, or folders of training runs.
        episodes: motions per policy; the same for all.
        seed: fixes the motions.
        suit: name of a shipped suit, or a suit file.
        gravity: earth, mars, moon or microgravity.
        out: folder for result.json.
        allow_uncertified: accept a suit whose torque could become infinite in some motion.
        json: print the result as JSON.
    """
    env = env or _trained_on(policies) or "ActiveSuit/ArmTracking-v0"
    options = {"suit": suit, "gravity": gravity, "allow_uncertified": allow_uncertified}
    make_env(env, **options)[0].close()  # reports a mistake before the folder is made
    folder = RunFolder(out) if out else None
    scores = run(env, policies, episodes, seed, **options)
    result = {
        "env": env,
        "episodes": episodes,
        "seed": seed,
        **options,
        "policies": [score.to_dict() for score in scores],
    }
    title = f"Human torque: {env}, {gravity}, {suit}, {episodes} episodes"
    conclude(result, title, score_table(scores), folder=folder, json=json)


def _trained_on(policies: tuple[str, ...]) -> str | None:
    """Returns the environment of the first policy that is the folder of a training run."""
    for name in policies:
        if name not in POLICIES and Path(name).is_dir():
            return training_config(name)["env"]
    return None


def run(
    env: str, policies: tuple[str, ...], episodes: int, seed: int, **options: object
) -> list[Score]:
    """Evaluates with a progress bar."""
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
