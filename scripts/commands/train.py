"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from ...checks import at_least
from ...envs.policies.build import residual_of
from ...envs.policies.residual import SCALE
from ...envs.policies.trained import OBSERVATION, portable
from ...errors import InputError
from ..arm_options import USUAL, ArmOptions
from ..options import Force, Gravity, RunSeed, Suit, choice, env_option, optional_number
from ..options import correctable as corrected_names
from ..options import levels as level_names
from ..options import policies as policy_names
from ..options import shipped_tasks as task_names
from ..options import suits as suit_names
from ..runs import scene
from ..settings import joined
from ..training.evaluations import MOTIONS
from ..training.hyperparameters import ALGORITHMS
from ..training.request import MOST_ROWS, TASK, TrainingRequest
from ..training.seeds import HIGHEST, seeds_of, train_all

MOST_STEPS = 10**11


def train(
    env: Annotated[str | None, env_option(TASK)] = None,
    task: Annotated[str | None, choice(task_names, "Name of a task, in place of --env.")] = None,
    level: Annotated[str | None, choice(level_names)] = None,
    algo: Annotated[str | None, choice(lambda: ALGORITHMS, usual="ppo")] = None,
    steps: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    rows: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    hyperparameters: Path | None = None,
    sensors: tuple[str, ...] = (),
    history: Annotated[int | None, optional_number("1", int)] = None,
    normalize: bool = False,
    belief: Annotated[str | None, choice(suit_names, usual="no belief")] = None,
    residual: Annotated[str | None, choice(corrected_names, usual="no correction")] = None,
    residual_scale: Annotated[float | None, optional_number(f"{SCALE}")] = None,
    teacher: Annotated[str | None, choice(policy_names, usual="no teacher")] = None,
    reward: str | None = None,
    suits: tuple[Annotated[str, choice(suit_names)], ...] = (),
    samples: bool = False,
    motions: Annotated[int | None, optional_number(f"{MOTIONS}", int)] = None,
    patience: Annotated[int | None, optional_number("never", int)] = None,
    seed: RunSeed = None,
    seeds: str | None = None,
    workers: int = 1,
    suit: Suit = None,
    gravity: Gravity = None,
    arm: ArmOptions = USUAL,
    torch_threads: int = 1,
    out: Path = Path("runs/train"),
    resume: bool = False,
    trust: bool = False,
    force: Force = False,
) -> None:
    """Train an assist policy with Stable-Baselines3.

    The folder is a policy: policy.safetensors and policy.json, which run no code, are all that
    others need of it. Ten times a run the policy is evaluated, and the best one is kept; the
    learner itself is in model.zip for --resume. Ctrl-C keeps what was learned; --resume goes on
    from there, with the options of the run. The commands that take a policy take the folder, and
    simulate with these options too.

    Args:
        level: Level of the task, which says what differs from episode to episode.
        algo: Learning algorithm: PPO or SAC of Stable-Baselines3, TQC or RecurrentPPO (a network
            with memory) of sb3-contrib.
        steps: Number of environment steps in total, including those before a resume; PPO rounds it
            up to whole updates.
        rows: Number of arms that are simulated together.
        hyperparameters: YAML file in the syntax of rl-zoo3, with what differs from the usual
            hyperparameters.
        sensors: Names of the sensor suites that the policy observes.
        history: Number of control periods whose observations it gets at once.
        normalize: Whether observations are divided by constants, to the size of 1.
        belief: Suit of a believed arm whose torques the policy observes.
        residual: Policy that the network corrects: action = policy + scale x network. The network
            begins at zero, and observes the action of the policy.
        residual_scale: Scale of the correction.
        teacher: Policy whose actions the network learns to repeat from its own sensors, in place of
            reinforcement learning; it may need other sensors.
        reward: Reward of your own in place of the shipped one, as MODULE:FUNCTION; scores stay.
        suits: Suits of which each episode draws one; evaluations have the suit of the scene.
        samples: Whether each episode draws the suit among the samples of its file, which the
            identification found plausible; evaluations are without.
        motions: Number of motions in the evaluation at each checkpoint, at least 8; 0 for none.
        patience: Number of evaluations without a better one after which the training ends.
        seeds: Seeds of several trainings, as 0-9 or 0,3,5, each in a folder of its own.
        workers: Number of trainings at once, with --seeds.
        torch_threads: Number of threads that torch computes with; with networks of this size more
            than one costs time.
        out: Folder of the run: a new or an empty one, or with --resume that of an earlier train.
        resume: Go on with the run in that folder.
        trust: Resume a run that you did not train on this machine, although that runs whatever code
            its files hold; no other command runs any.
    """
    for name, count, least, most in (
        ("torch-threads", torch_threads, 1, MOST_STEPS),
        ("workers", workers, 1, MOST_STEPS),
        ("steps", steps, 1, MOST_STEPS),
        ("rows", rows, 1, MOST_ROWS),
        ("seed", seed, 0, HIGHEST),
        ("motions", motions or None, MOTIONS, MOST_STEPS),  # 0 is none
        ("patience", patience, 1, MOST_STEPS),
    ):
        if count is not None:
            at_least(name, count, least, most)
    if trust and not resume:
        raise InputError(
            "--trust is given without --resume: it is about the files of a run to resume"
        )
    if residual is None and residual_scale is not None:
        raise InputError("--residual-scale is given without --residual: name a policy, too")
    drawn = {"suit": "samples" if samples else None, "suits": list(suits) or None}
    given: dict[str, Any] = {
        **{"algo": algo, "seed": seed, "rows": rows, "steps": steps, "level": level},
        **{"sensors": list(sensors) or None, "history": history, "normalize": normalize or None},
        "belief": None if belief is None else {"suit": portable(belief)},
        "residual": residual and residual_of(residual, residual_scale or SCALE),
        **{"teacher": teacher, "reward": reward, "motions": motions, "patience": patience},
        "randomize": {name: one for name, one in drawn.items() if one} or None,
    }
    others, arm = arm.split((*OBSERVATION, "level", "reward", "randomize"))
    given = joined({name: one for name, one in given.items() if one is not None}, others)
    request = TrainingRequest(
        given=given,
        file=hyperparameters,
        scene=partial(scene, arm, env=env, task=task, suit=suit, gravity=gravity, trusted=trust),
        **{"resume": resume, "trust": trust, "force": force, "torch_threads": torch_threads},
    )
    if seeds is None:
        request.one(out)
        return
    if seed is not None or motions == 0:
        other = "--seed is" if seed is not None else "--motions 0 is"
        raise InputError(f"{other} given, and --seeds compares evaluations: leave one of them out")
    train_all(request, seeds_of(seeds), out, workers)
