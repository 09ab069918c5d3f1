"""`activesuit train`: trains a policy by reinforcement learning (needs the extra `train`)."""

import json as jsonlib
from contextlib import closing
from pathlib import Path
from typing import Any, Literal

from ...checks import at_least
from ...envs.evaluation import make_env
from ...envs.policies.trained import algorithm_class, load_network
from ...errors import InputError
from ...files import replacing
from ..arm_options import USUAL, ArmOptions
from ..options import Env, Gravity, Seed, SuitName
from ..output import Bar, RunFolder, progress, telling

# Short horizon: effort answers an action at once. The start is gentle (log_std) and the
# networks small, as the task is nearly a function of angle, rate and target.
PPO_OPTIONS: dict[str, Any] = {
    "n_steps": 256,
    "batch_size": 256,
    "gamma": 0.9,
    "gae_lambda": 0.9,
    "learning_rate": 1e-3,
    "policy_kwargs": {"log_std_init": -1.0},
}
SAC_OPTIONS: dict[str, Any] = {"gamma": 0.9, "buffer_size": 100_000, "learning_starts": 1000}
PARALLEL = {"ppo": 8, "sac": 1}
CHECKPOINTS = 10  # per run


def train(
    env: Env = "ActiveSuit/ElbowFlexion-v0",
    algo: Literal["ppo", "sac"] = "ppo",
    steps: int = 100_000,
    seed: Seed = 0,
    suit: SuitName = "mock-suit",
    gravity: Gravity = "earth",
    arm: ArmOptions = USUAL,
    out: Path = Path("runs/train"),
    resume: bool = False,
) -> None:
    """Train an assist policy with Stable-Baselines3.

    The folder gets config.json, model.zip (written at every checkpoint) and TensorBoard logs.
    Ctrl-C keeps what was learned; --resume goes on from there.

    Args:
        algo: Learning algorithm, PPO or SAC of Stable-Baselines3.
        steps: Number of environment steps in total, including those before a resume; PPO rounds it
            up to whole updates of 2048.
        out: Folder of the run.
        resume: Go on with the run in that folder.
    """
    at_least("steps", steps, 1)
    at_least("seed", seed, 0)
    algorithm_class(algo)  # reports a missing extra before the folder is made
    if arm.coupling == "none":
        raise InputError("coupling is 'none': there is no motor to train for; use rigid or cuffs")
    options = arm.config(suit, gravity)
    make_env(env, **options)[0].close()
    config = {"env": env, "algo": algo, "seed": seed, **options}
    _check_folder(out, config, resume)
    folder = RunFolder(out)
    folder.json("config.json", config)
    with (
        telling(lambda: _kept(folder)),
        closing(_environments(env, algo, seed, options)) as environments,
    ):
        if resume:
            learner = _resumed(algo, environments, folder)
        else:
            learner = _new(algo, environments, folder, seed)
        _learn(learner, steps, folder, config, resume)
    print(
        f"trained {learner.num_timesteps} steps; compare with, and the options of this run: "
        f"activesuit evaluate --env {env} --policies none {folder.path}"
    )


def _check_folder(out: Path, config: dict[str, Any], resume: bool) -> None:
    present = (out / "model.zip").exists()
    if present and not resume:
        raise InputError(f"{str(out)!r} holds a trained run: add --resume, or choose another --out")
    if resume and not present:
        raise InputError(f"{str(out)!r} holds no model.zip to resume: train without --resume first")
    if resume:
        try:
            before = jsonlib.loads((out / "config.json").read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"{str(out / 'config.json')!r} cannot be read: restore it") from error
        for key, value in config.items():
            if before.get(key) != value:
                raise InputError(
                    f"the run in {str(out)!r} has {key} {before.get(key)!r}, not {value!r}: resume "
                    "it with the options it was started with"
                )


def _kept(folder: RunFolder) -> str:
    if (folder / "model.zip").exists():
        return f"the last checkpoint is kept in {folder.path}; go on with --resume"
    return "nothing was learned yet; start the training again"


def _environments(env: str, algo: str, seed: int, options: dict[str, Any]) -> Any:
    from stable_baselines3.common.env_util import make_vec_env

    return make_vec_env(
        f"activesuit:{env.removeprefix('activesuit:')}",
        n_envs=PARALLEL[algo],
        seed=seed,
        env_kwargs=options,
    )


def _new(algo: str, environments: Any, folder: RunFolder, seed: int) -> Any:
    settings = PPO_OPTIONS if algo == "ppo" else SAC_OPTIONS
    logs = str(folder / "tensorboard")
    return algorithm_class(algo)(
        "MlpPolicy", environments, seed=seed, device="cpu", tensorboard_log=logs, **settings
    )


def _resumed(algo: str, environments: Any, folder: RunFolder) -> Any:
    learner = load_network(algo, folder / "model.zip", env=environments)
    if (folder / "replay.pkl").exists():
        learner.load_replay_buffer(folder / "replay.pkl")
    return learner


def _learn(
    learner: Any, steps: int, folder: RunFolder, config: dict[str, Any], resume: bool
) -> None:
    """Trains until `steps` are done in total, and saves; Ctrl-C ends the training earlier."""
    done, algo = learner.num_timesteps, config["algo"]
    if done >= steps:
        raise InputError(f"the run has {done} steps already: give --steps above that to go on")
    interrupted = False
    with progress(f"{algo} on {config['env']}", steps) as bar:
        try:
            learner.learn(
                steps - done,
                callback=_callback(learner, folder, bar, steps),
                reset_num_timesteps=not resume,
                tb_log_name=algo,
            )
        except KeyboardInterrupt:
            interrupted = True
    _save(learner, folder)
    if interrupted:
        raise KeyboardInterrupt(
            f"{learner.num_timesteps} steps are kept in {folder.path}; go on with --resume"
        )


def _save(learner: Any, folder: RunFolder) -> None:
    with replacing(folder / "model.zip") as scratch:
        learner.save(scratch)
    if hasattr(learner, "save_replay_buffer"):
        with replacing(folder / "replay.pkl") as scratch:
            learner.save_replay_buffer(scratch)


def _callback(learner: Any, folder: RunFolder, bar: Bar, steps: int) -> Any:
    from stable_baselines3.common.callbacks import BaseCallback

    class Checkpoints(BaseCallback):
        """Callback that saves ten times a run and moves the progress bar."""

        next_save = learner.num_timesteps + steps // CHECKPOINTS

        def _on_step(self) -> bool:
            bar.move_to(self.num_timesteps)
            if self.num_timesteps >= self.next_save:
                self.next_save = self.num_timesteps + steps // CHECKPOINTS
                _save(learner, folder)
            return True

    return Checkpoints()
