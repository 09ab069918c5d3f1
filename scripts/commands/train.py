"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro

from ...checks import at_least, check_seed
from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies import needed_options
from ...envs.policies.build import base_of, residual_of
from ...envs.policies.network import CARD, Card, Residual, read_card
from ...envs.policies.residual import SCALE
from ...envs.policies.trained import OBSERVATION, environment_of, portable, training_of
from ...errors import InputError, shown
from ..arm_options import USUAL, ArmOptions
from ..options import Force, Gravity, RunSeed, Suit, choice, env_option, optional_number
from ..options import levels as level_names
from ..options import policies as policy_names
from ..options import suits as suit_names
from ..options import tasks as task_names
from ..output import RunFolder, say, telling
from ..own_files import is_own
from ..runs import Scene, scene
from ..training.checkpoints import CHECKPOINT, Checkpoint
from ..training.distillation import DAGGER, distill
from ..training.evaluations import MOTIONS
from ..training.hyperparameters import ALGORITHMS, algorithm_class, hyperparameters
from ..training.run import TRAINING_ONLY, learn
from ..training.seeds import seeds_of, train_all

TASK = "ActiveSuit/ElbowFlexion-v0"
MOST_STEPS, MOST_ROWS = 10**11, 10**5
KEPT = ("algo", "seed", "rows", "steps", "level", "motions", "patience", *TRAINING_ONLY)


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
    belief: Annotated[str | None, choice(suit_names, usual="none")] = None,
    residual: Annotated[str | None, choice(policy_names, usual="none")] = None,
    residual_scale: Annotated[float | None, optional_number(f"{SCALE}")] = None,
    teacher: Annotated[str | None, choice(policy_names, usual="none")] = None,
    reward: str | None = None,
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
        hyperparameters_file: YAML file in the syntax of rl-zoo3, with what differs from the usual
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
    at_least("torch-threads", torch_threads, 1)
    at_least("workers", workers, 1)
    if steps is not None:
        at_least("steps", steps, 1, MOST_STEPS)
    if rows is not None:
        at_least("rows", rows, 1, MOST_ROWS)
    if seed is not None:
        check_seed(seed)
    if motions is not None and motions != 0:
        at_least("motions", motions, MOTIONS)
    if patience is not None:
        at_least("patience", patience, 1)
    if seeds is not None and seed is not None:
        raise InputError("--seed and --seeds are given: give one of them")
    given: dict[str, Any] = {"algo": algo, "seed": seed, "rows": rows, "steps": steps}
    given |= {"level": level, "history": history, "sensors": list(sensors) or None}
    given |= {"normalize": normalize or None, "belief": belief and {"suit": portable(belief)}}
    given |= {"reward": reward, "motions": motions, "patience": patience}
    given |= {"randomize": {"suit": "samples"} if samples else None}
    given |= {"residual": _residual(residual, residual_scale)}
    request = _Request(
        given={name: value for name, value in given.items() if value is not None},
        file=hyperparameters_file,
        scene=partial(scene, arm, env=env, task=task, suit=suit, gravity=gravity, trusted=trust),
        resume=resume,
        trust=trust,
        force=force,
        torch_threads=torch_threads,
    )
    if teacher is not None:
        _distill(request, teacher, out, seeds)
    elif seeds is not None:
        if motions == 0:
            raise InputError("--motions is 0, and --seeds compares evaluations: leave one out")
        train_all(request.seed, seeds_of(seeds), out, workers, resume=resume, force=force)
    else:
        done = request.one(out)
        say(
            f"trained {done} steps; compare, in this task and with these options: "
            f"activesuit evaluate --policies none {out}"
        )


@dataclass(frozen=True, kw_only=True)
class _Request:
    """What the command was asked for.

    Attributes:
        given: Options that are given, by their names in a card.
        file: File of hyperparameters; None if none is given.
        scene: Function that returns the scene, of the level and of the run that goes on.
        resume: Whether to go on with what is there.
        trust: Whether to resume files of others.
        force: Whether to replace what is there.
        torch_threads: Number of threads of torch.
    """

    given: dict[str, Any]
    file: Path | None
    scene: partial[Scene]
    resume: bool
    trust: bool
    force: bool
    torch_threads: int

    def seed(self, out: Path, seed: int) -> None:
        """Trains with a seed in a folder, or continues what is there."""
        resume = self.resume and (out / CHECKPOINT).exists()
        file = None if resume else self.file
        replace(self, resume=resume, file=file, given={**self.given, "seed": seed}).one(out)

    def one(self, out: Path) -> int:
        """Trains, or goes on, in a folder; returns the number of steps."""
        checkpoint = _check_folder(out, self.resume, self.trust, self.force)
        before = _before(out, self.trust) if self.resume else {}
        if self.resume and self.file is not None:
            raise InputError("--hyperparameters is given with --resume: a run keeps its own")
        config = _config(before, self.given, out)
        chosen = self.chosen(config, out if self.resume else None)
        algorithm_class(config["algo"])  # reports a missing extra before the folder is made
        settings = hyperparameters(config["algo"], chosen.env, self.file)
        settings |= before.get("hyperparameters", {})
        config = {"rows": int(settings["n_envs"]), "steps": int(settings["n_timesteps"]), **config}
        at_least("rows", config["rows"], 1, MOST_ROWS)  # that of a file or of a run, too
        card, options = card_and_options(chosen, {**config, "hyperparameters": settings})
        folder = RunFolder(out, "train", force=self.force or self.resume)
        with telling(lambda: _kept(folder)):
            done = learn(folder, card, options, checkpoint, self.torch_threads)
        return done

    def chosen(self, config: dict[str, Any], run: Path | None = None) -> Scene:
        """Returns the task and the options of the arms."""
        chosen = self.scene(level=config.get("level"), run=run, usual={"env": TASK})
        if "task" in chosen.options:
            raise InputError("--task is the file of a motion: name a task to train for")
        if chosen.options["coupling"] == "none":
            raise InputError(
                "coupling is 'none': there is no motor to train for; use rigid or cuffs"
            )
        return chosen


def card_and_options(chosen: Scene, config: dict[str, Any]) -> tuple[Card, dict[str, Any]]:
    """Returns the card of a policy, and the options of its environment.

    Args:
        chosen: Task and arms.
        config: All that describes the training, with what the policy observes.
    """
    from ...envs.policies.saving import card_of

    config = dict(config)
    observation = {name: config.pop(name) for name in OBSERVATION if name in config}
    residual: Residual | None = config.pop("residual", None)
    if residual is not None and "sensors" not in observation:
        observation["sensors"] = list(needed_options(base_of(residual))["sensors"])
    if "belief" in observation:
        sensors = observation.get("sensors", ["encoders"])
        observation["sensors"] = [*sensors, *({"belief"} - {*sensors})]
    config.pop("level", None)
    options = {**chosen.options, **observation}
    arms = make_arms(chosen.env, 1, **options)
    plant = Plant.of(arms.episodes)
    arms.close()
    return card_of(plant, {"env": chosen.env, **options}, config, residual), options


def _residual(given: str | None, scale: float | None) -> Residual | None:
    if given is None:
        if scale is not None:
            raise InputError("--residual-scale is given without --residual: name a policy, too")
        return None
    return residual_of(given, SCALE if scale is None else scale)


def _distill(request: _Request, teacher: str, out: Path, seeds: str | None) -> None:
    """Trains a student of another policy."""
    given = dict(request.given)
    for name in ("algo", "residual", "reward", "patience"):
        if name in given:
            raise InputError(f"--{name} is given with --teacher: leave one of them out")
    for name, there in (("seeds", seeds), ("hyperparameters", request.file)):
        if there is not None:
            raise InputError(f"--{name} is given with --teacher: leave one of them out")
    if request.resume:
        raise InputError("--resume is given with --teacher: a student takes minutes, train it anew")
    _check_folder(out, False, request.trust, request.force)
    config = {"seed": 0, "motions": MOTIONS, **DAGGER, **given}
    card, options = card_and_options(
        request.chosen(config), {**config, "algo": "dagger", "teacher": teacher}
    )
    folder = RunFolder(out, "train", force=request.force)
    with telling(lambda: "nothing was learned yet; start the training again"):
        done = distill(folder, card, options, teacher, request.torch_threads)
    say(
        f"trained {done} steps; compare, in this task and with these options: "
        f"activesuit evaluate --policies none {out}"
    )


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


def _before(out: Path, trust: bool) -> dict[str, Any]:
    """Returns what the card of a run says of it."""
    found = {**environment_of(out), **training_of(out)}
    residual = read_card(out).residual
    if residual is not None:
        base_of(residual)
        found["residual"] = residual
    if "reward" in found and not (trust or is_own((out / CARD).read_bytes())):
        raise InputError(
            f"the run in {str(out)!r} needs the reward {shown(found['reward'])}, and its {CARD} is "
            "not of this machine: add --trust if that module may be imported"
        )
    return found


def _config(before: dict[str, Any], given: dict[str, Any], out: Path) -> dict[str, Any]:
    """Returns algo, seed and so on: those of the run before, which stay, those given, the usual."""
    for name, value in given.items():
        if before and name not in ("steps", "motions", "patience") and before.get(name) != value:
            raise InputError(
                f"this command has --{name} {shown(value)}, and the run in {str(out)!r} was "
                f"trained with {shown(before.get(name))}: leave --{name} out, or train another run"
            )
    names = (*KEPT, "residual", *OBSERVATION)
    found = {name: before[name] for name in names if name in before}
    return {"algo": "ppo", "seed": 0, "motions": MOTIONS, **found, **given}


def _kept(folder: RunFolder) -> str:
    if (folder / CHECKPOINT).exists():
        return f"the last checkpoint is kept in {folder.path}; go on with --resume"
    return "nothing was learned yet; start the training again"
