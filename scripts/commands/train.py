"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import tyro

from ...assets import load_suit, suit_names
from ...checks import at_least, check_seed
from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies.network import CARD, WEIGHTS, Card, card_file
from ...envs.policies.trained import OBSERVATION, OWN_SUIT, environment_of, training_of
from ...errors import InputError, shown
from ..arm_options import USUAL, ArmOptions
from ..hyperparameters import ALGORITHMS, algorithm_class, hyperparameters
from ..learning import (
    CHECKPOINT,
    REPLAY,
    Checkpoint,
    checkpoints,
    new_learner,
    resumed_learner,
    save,
    threads,
    training_environments,
    write_own,
)
from ..options import Force, Gravity, RunSeed, Suit, choice, env_option, optional_number
from ..options import levels as level_names
from ..options import tasks as task_names
from ..output import RunFolder, messages, progress, say, telling
from ..own_files import notes_folder
from ..runs import Scene, scene

TASK = "ActiveSuit/ElbowFlexion-v0"
MOST_STEPS, MOST_ROWS = 10**11, 10**5


def train(
    env: Annotated[str | None, env_option(TASK)] = None,
    task: Annotated[str | None, choice(task_names, "Name of a task, in place of --env.")] = None,
    level: Annotated[str | None, choice(level_names)] = None,
    algo: Annotated[str | None, choice(lambda: ALGORITHMS, usual="ppo")] = None,
    steps: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    rows: Annotated[int | None, optional_number("that of the hyperparameters", int)] = None,
    hyperparameters_file: Annotated[Path | None, tyro.conf.arg(name="hyperparameters")] = None,
    sensors: tuple[str, ...] = (),
    history: Annotated[int | None, optional_number("1", int)] = None,
    normalize: bool = False,
    seed: RunSeed = None,
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
    others need of it. It gets TensorBoard logs, and model.zip for --resume, at every checkpoint.
    Ctrl-C keeps what was learned; --resume goes on from there, with the options of the run. The
    commands that take a policy take the folder, and simulate with these options too.

    Args:
        level: Level of the task, which says what differs from episode to episode.
        algo: Learning algorithm: PPO or SAC of Stable-Baselines3, TQC or RecurrentPPO (a network
            with memory) of sb3-contrib.
        steps: Number of environment steps in total, including those before a resume; PPO rounds it
            up to whole updates.
        rows: Number of arms that are simulated together.
        hyperparameters_file: YAML file in the syntax of rl-zoo3, with what differs from the usual
            hyperparameters.
        sensors: Names of the sensor suites that the policy observes.
        history: Number of control periods whose observations it gets at once.
        normalize: Whether observations are divided by constants, to the size of 1.
        torch_threads: Number of threads that torch computes with; with networks of this size more
            than one costs time.
        out: Folder of the run: a new or an empty one, or with --resume that of an earlier train.
        resume: Go on with the run in that folder.
        trust: Resume a run that you did not train on this machine, although that runs whatever code
            its files hold; no other command runs any.
    """
    at_least("torch-threads", torch_threads, 1)
    if steps is not None:
        at_least("steps", steps, 1, MOST_STEPS)
    if rows is not None:
        at_least("rows", rows, 1, MOST_ROWS)
    if seed is not None:
        check_seed(seed)
    checkpoint = _check_folder(out, resume, trust, force)
    before = {**environment_of(out), **training_of(out)} if resume else {}
    given = {"algo": algo, "seed": seed, "rows": rows, "level": level, "history": history}
    given |= {"sensors": list(sensors) or None, "normalize": normalize or None}
    if resume and hyperparameters_file is not None:
        raise InputError("--hyperparameters is given with --resume: a run keeps its own")
    config = _config(before, {**given, "steps": steps}, out)
    chosen = scene(
        arm,
        env=env,
        task=task,
        level=config.get("level"),
        suit=suit,
        gravity=gravity,
        run=out if resume else None,
        trusted=trust,
        usual={"env": TASK},
    )
    if "task" in chosen.options:
        raise InputError("--task is the file of a motion: name a task to train for")
    if chosen.options["coupling"] == "none":
        raise InputError("coupling is 'none': there is no motor to train for; use rigid or cuffs")
    algorithm_class(config["algo"])  # reports a missing extra before the folder is made
    settings = hyperparameters(config["algo"], chosen.env, hyperparameters_file)
    settings |= before.get("hyperparameters", {})
    config = {"rows": int(settings["n_envs"]), "steps": int(settings["n_timesteps"]), **config}
    at_least("rows", config["rows"], 1, MOST_ROWS)  # that of a file or of a run, too
    observation = {name: config.pop(name) for name in OBSERVATION if name in config}
    options = {**chosen.options, **observation}
    arms = make_arms(chosen.env, 1, **options)
    card = _card(chosen, Plant.of(arms.episodes), options, {**config, "hyperparameters": settings})
    arms.close()
    folder = RunFolder(out, "train", force=force or resume)
    with telling(lambda: _kept(folder)):
        learner = _train(folder, card, options, checkpoint, torch_threads)
    say(
        f"trained {learner.num_timesteps} steps; compare, in this task and with these options: "
        f"activesuit evaluate --policies none {folder.path}"
    )


def _card(chosen: Scene, plant: Plant, options: dict[str, Any], training: dict[str, Any]) -> Card:
    from ...envs.policies.saving import card_of

    training = {name: value for name, value in training.items() if name != "level"}
    return card_of(plant, {"env": chosen.env, **options}, training)


def _check_folder(out: Path, resume: bool, trust: bool, force: bool) -> Checkpoint | None:
    """Returns the checkpoint to go on from; None for a new run."""
    if resume:
        return Checkpoint.read(out, trust=trust)
    if trust:
        raise InputError(
            "--trust is given without --resume: it is about the files of a run to resume"
        )
    if (out / CHECKPOINT).exists() and not force:
        raise InputError(
            f"{str(out)!r} holds a trained run: add --resume to go on, --force to begin anew, or "
            "choose another --out"
        )
    return None


def _config(before: dict[str, Any], given: dict[str, Any], out: Path) -> dict[str, Any]:
    """Returns algo, seed and so on: those of the run before, which stay, those given, the usual."""
    given = {name: value for name, value in given.items() if value is not None}
    for name, value in given.items():
        if before and name != "steps" and before.get(name) != value:
            raise InputError(
                f"this command has --{name} {shown(value)}, and the run in {str(out)!r} was "
                f"trained with {shown(before.get(name))}: leave --{name} out, or train another run"
            )
    names = ("algo", "seed", "rows", "steps", "level", *OBSERVATION)
    found = {name: before[name] for name in names if name in before}
    return {"algo": "ppo", "seed": 0, **found, **given}


def _begin(folder: RunFolder, card: Card, *, resume: bool) -> Card:
    """Writes the card, and beside it a copy of the suit file if there is one; returns the card."""
    if not resume:
        for name in (CHECKPOINT, REPLAY, WEIGHTS):
            folder.claim(name).unlink(missing_ok=True)
    suit = card.environment["suit"]
    if suit != "none" and suit not in suit_names():
        if Path(suit) != folder / OWN_SUIT:
            with folder.replacing(OWN_SUIT) as scratch:
                load_suit(suit).save(scratch)
        card = card.model_copy(update={"environment": {**card.environment, "suit": OWN_SUIT}})
    if not resume:
        write_own(folder, {CARD: card_file(card)})
    return card


def _kept(folder: RunFolder) -> str:
    if (folder / CHECKPOINT).exists():
        return f"the last checkpoint is kept in {folder.path}; go on with --resume"
    return "nothing was learned yet; start the training again"


def _train(
    folder: RunFolder,
    card: Card,
    options: dict[str, Any],
    checkpoint: Checkpoint | None,
    torch_threads: int,
) -> Any:
    env, training = card.environment["env"], card.training
    algo, seed = training["algo"], training["seed"]
    with (
        threads(torch_threads),
        closing(training_environments(env, training["rows"], seed, options)) as environments,
    ):
        if checkpoint:
            learner = resumed_learner(algo, environments, checkpoint)
        else:
            learner = new_learner(algo, environments, folder, seed, training["hyperparameters"])
        done, steps = learner.num_timesteps, training["steps"]
        if done >= steps:
            raise InputError(f"the run has {done} steps already: give --steps above that to go on")
        card = _begin(folder, card, resume=bool(checkpoint))
        _learn(learner, folder, card, f"{algo} on {env}", new=not checkpoint)
    return learner


def _learn(learner: Any, folder: RunFolder, card: Card, title: str, *, new: bool) -> None:
    """Trains until all steps are done, and saves; Ctrl-C ends the training earlier."""
    steps = card.training["steps"]
    interrupted = False
    with progress(title, steps) as bar:
        try:
            learner.learn(
                steps - learner.num_timesteps,
                callback=checkpoints(learner, folder, card, bar, steps),
                reset_num_timesteps=new,
                tb_log_name=card.training["algo"],
            )
        except KeyboardInterrupt:
            interrupted = True
    if not save(learner, folder, card):
        messages.print(
            f"note: {notes_folder()} cannot be written, so that --resume will need --trust"
        )
    if interrupted:
        raise KeyboardInterrupt(
            f"{learner.num_timesteps} steps are kept in {folder.path}; go on with --resume"
        )
