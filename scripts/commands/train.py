"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from ...checks import at_least
from ...envs.policies.network import Residual
from ...envs.policies.registry import residual_of
from ...envs.policies.residual import SCALE
from ...envs.policies.trained import OBSERVATION, portable
from ...errors import InputError
from ..options import Force, RunSeed, choice, correctable, optional_number, policies
from ..scene import scene
from ..training.evaluations import MOTIONS
from ..training.hyperparameters import ALGORITHMS
from ..training.request import MOST_ROWS, TrainingRequest
from ..training.seeds import HIGHEST, seeds_of, train_all

MOST_STEPS = 10**11
OF_TRAINING = (*OBSERVATION, "level", "reward", "randomize")  # own entries of a card


def train(
    algo: Annotated[str | None, choice(lambda: ALGORITHMS, usual="ppo")] = None,
    steps: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    rows: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    hyperparameters: Path | None = None,
    residual: Annotated[str | None, choice(correctable, usual="no correction")] = None,
    residual_scale: Annotated[float | None, optional_number(f"{SCALE}")] = None,
    teacher: Annotated[str | None, choice(policies, usual="no teacher")] = None,
    motions: Annotated[int | None, optional_number(f"{MOTIONS}", int)] = None,
    patience: Annotated[int | None, optional_number("never", int)] = None,
    seed: RunSeed = None,
    seeds: str | None = None,
    workers: int = 1,
    torch_threads: int = 1,
    out: Path = Path("runs/train"),
    resume: bool = False,
    trust: bool = False,
    force: Force = False,
    **options: Any,
) -> Path:
    """Train an assist policy with Stable-Baselines3.

    The folder of the run is a policy for other commands, which simulate with the options of the
    run. To pass the policy on, copy policy.safetensors and policy.json, which run no code. The
    policy is evaluated ten times during a run, and the best policy is kept; model.zip has the
    learner for --resume. After Ctrl-C the learner is kept, and --resume continues the training with
    the options of the run. By default the task is ElbowFlexion. --randomize changes the training
    alone, and evaluations have the given suit.

    Args:
        algo: Learning algorithm: PPO or SAC of Stable-Baselines3, TQC or RecurrentPPO (a network
            with memory) of sb3-contrib.
        steps: Number of environment steps in total, including steps before a resume; PPO rounds
            the number up to whole updates.
        rows: Number of arms that are simulated together.
        hyperparameters: YAML file in the syntax of rl-zoo3, with hyperparameters that replace the
            usual hyperparameters.
        residual: Policy that the network corrects: action = policy + scale x network. The network
            begins at zero, and observes the action of the policy.
        residual_scale: Scale of the correction.
        teacher: Policy whose actions the network learns to repeat from its own sensors, in place of
            reinforcement learning; the teacher may need other sensors.
        motions: Number of motions in each evaluation, at least 8; 0 for no evaluations.
        patience: Number of evaluations without an improvement after which the training ends.
        seeds: Seeds of several trainings, as 0-9 or 0,3,5, each in a folder of its own.
        workers: Number of trainings at once, with --seeds.
        torch_threads: Number of threads of torch; networks of this size are slower with several.
        out: Folder of the run: a new or an empty folder, or with --resume the folder of a run.
        resume: Continue the run in that folder.
        trust: Resume a run that you did not train on this machine, although resuming runs the code
            in its files; no other command runs that code.

    Returns:
        The folder, which is the name of the policy; its result.json has all evaluations.
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
    if seeds is not None and seed is not None:
        raise InputError("--seed and --seeds are given: give one of them")
    given: dict[str, Any] = {"algo": algo, "seed": seed, "rows": rows, "steps": steps}
    given |= {"motions": motions, "patience": patience, "teacher": teacher}
    given |= {"residual": _residual(residual, residual_scale)}
    present = {name: value for name, value in given.items() if value is not None}
    present |= _lists({name: options.pop(name) for name in OF_TRAINING if name in options})
    request = TrainingRequest(
        given=_portable(present),
        file=hyperparameters,
        scene=partial(scene, options, trusted=trust),
        resume=resume,
        trust=trust,
        force=force,
        torch_threads=torch_threads,
    )
    if seeds is None:
        request.one(out)
        return out
    if motions == 0:
        raise InputError(
            "--motions 0 is given, and --seeds compares evaluations: leave one of them out"
        )
    train_all(request, seeds_of(seeds), out, workers)
    return out


def _lists(given: Any) -> Any:
    """Returns options with lists in place of tuples, as after reading JSON."""
    if isinstance(given, dict):
        return {name: _lists(one) for name, one in given.items()}
    return list(given) if isinstance(given, tuple) else given


def _portable(given: dict[str, Any]) -> dict[str, Any]:
    """Returns options with the content of a suit file in place of the path of a believed suit."""
    belief = given.get("belief")
    if not isinstance(belief, dict) or not isinstance(belief.get("suit"), str):
        return given
    return {**given, "belief": {**belief, "suit": portable(belief["suit"])}}


def _residual(given: str | None, scale: float | None) -> Residual | None:
    if given is None:
        if scale is not None:
            raise InputError("--residual-scale is given without --residual: name a policy, too")
        return None
    return residual_of(given, SCALE if scale is None else scale)
