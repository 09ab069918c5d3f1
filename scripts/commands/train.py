"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

from ...assets import load_suit, suit_names
from ...checks import at_least, check_seed
from ...envs.making import make_arms
from ...envs.policies.network import ARCHITECTURES, algorithm_class
from ...envs.policies.trained import CHECKPOINT, CONFIG, OWN_SUIT, training_config
from ...errors import InputError, unknown_name
from ..arm_options import USUAL, ArmOptions
from ..learning import (
    REPLAY,
    Checkpoint,
    checkpoints,
    new_learner,
    resumed_learner,
    save,
    threads,
    training_environments,
)
from ..options import Force, Gravity, RunSeed, Suit, choice, env_option, optional_number
from ..output import RunFolder, messages, progress, say, telling, to_json
from ..own_files import note, notes_folder
from ..runs import Scene, scene

TASK = "ActiveSuit/ElbowFlexion-v0"
STEPS, MOST_STEPS = 100_000, 10**11


def train(
    env: Annotated[str | None, env_option(TASK)] = None,
    algo: Annotated[str | None, choice(lambda: ARCHITECTURES, usual="ppo")] = None,
    steps: Annotated[int | None, optional_number(f"{STEPS}", int)] = None,
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

    The folder gets config.json, model.zip (written at every checkpoint) and TensorBoard logs.
    Ctrl-C keeps what was learned; --resume goes on from there, with the options of the run. The
    commands that take a policy take the folder, and simulate with these options too.

    Args:
        algo: Learning algorithm, PPO or SAC of Stable-Baselines3.
        steps: Number of environment steps in total, including those before a resume; PPO rounds it
            up to whole updates of 2048.
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
    if seed is not None:
        check_seed(seed)
    checkpoint = _check_folder(out, resume, trust, force)
    config = _config(training_config(out) if resume else {}, out, algo, steps, seed)
    chosen = scene(
        arm,
        env=env,
        suit=suit,
        gravity=gravity,
        run=out if resume else None,
        trusted=trust,
        usual={"env": TASK},
    )
    if chosen.options["coupling"] == "none":
        raise InputError("coupling is 'none': there is no motor to train for; use rigid or cuffs")
    algorithm_class(config["algo"])  # reports a missing extra before the folder is made
    make_arms(chosen.env, 1, **chosen.options).close()
    folder = RunFolder(out, "train", force=force or resume)
    with telling(lambda: _kept(folder)):
        learner = _train(folder, chosen, config, checkpoint, torch_threads)
    say(
        f"trained {learner.num_timesteps} steps; compare, in this task and with these options: "
        f"activesuit evaluate --policies none {folder.path}"
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


def _config(
    before: dict[str, Any], out: Path, algo: str | None, steps: int | None, seed: int | None
) -> dict[str, Any]:
    """Returns algo, seed and steps: those given, those of the run before, or the usual ones."""
    if algo is not None and algo not in ARCHITECTURES:
        raise unknown_name("algo", algo, ARCHITECTURES)
    for name, given in (("algo", algo), ("seed", seed)):
        if given is not None and before.get(name, given) != given:
            raise InputError(
                f"this command has --{name} {given!r}, and the run in {str(out)!r} was trained "
                f"with {before[name]!r}: leave --{name} out, or train another run"
            )
    given = {"algo": algo, "seed": seed, "steps": steps}
    found = {name: before[name] for name in given if name in before}
    return {
        **{"algo": "ppo", "seed": 0, "steps": STEPS},
        **found,
        **{name: value for name, value in given.items() if value is not None},
    }


def _begin(folder: RunFolder, config: dict[str, Any], *, resume: bool) -> None:
    """Writes config.json, and beside it a copy of the suit file if there is one."""
    if not resume:
        for name in (CHECKPOINT, REPLAY):
            folder.claim(name).unlink(missing_ok=True)
    suit = config["suit"]
    if suit != "none" and suit not in suit_names():
        if Path(suit) != folder / OWN_SUIT:
            with folder.replacing(OWN_SUIT) as scratch:
                load_suit(suit).save(scratch)
        config = {**config, "suit": OWN_SUIT}
    with folder.replacing(CONFIG) as scratch:
        scratch.write_text(to_json(config) + "\n", encoding="utf-8")
        note(scratch, folder / CONFIG)


def _kept(folder: RunFolder) -> str:
    if (folder / CHECKPOINT).exists():
        return f"the last checkpoint is kept in {folder.path}; go on with --resume"
    return "nothing was learned yet; start the training again"


def _train(
    folder: RunFolder,
    chosen: Scene,
    config: dict[str, Any],
    checkpoint: Checkpoint | None,
    torch_threads: int,
) -> Any:
    algo, seed = config["algo"], config["seed"]
    with (
        threads(torch_threads),
        closing(training_environments(chosen.env, algo, seed, chosen.options)) as environments,
    ):
        if checkpoint:
            learner = resumed_learner(algo, environments, checkpoint)
        else:
            learner = new_learner(algo, environments, folder, seed)
        done, steps = learner.num_timesteps, config["steps"]
        if done >= steps:
            raise InputError(f"the run has {done} steps already: give --steps above that to go on")
        _begin(folder, {"env": chosen.env, **config, **chosen.options}, resume=bool(checkpoint))
        _learn(learner, folder, config, f"{algo} on {chosen.env}", new=not checkpoint)
    return learner


def _learn(
    learner: Any, folder: RunFolder, config: dict[str, Any], title: str, *, new: bool
) -> None:
    """Trains until all steps are done, and saves; Ctrl-C ends the training earlier."""
    steps = config["steps"]
    interrupted = False
    with progress(title, steps) as bar:
        try:
            learner.learn(
                steps - learner.num_timesteps,
                callback=checkpoints(learner, folder, bar, steps),
                reset_num_timesteps=new,
                tb_log_name=config["algo"],
            )
        except KeyboardInterrupt:
            interrupted = True
    if not save(learner, folder):
        messages.print(
            f"note: {notes_folder()} cannot be written, so that --resume will need --trust"
        )
    if interrupted:
        raise KeyboardInterrupt(
            f"{learner.num_timesteps} steps are kept in {folder.path}; go on with --resume"
        )
