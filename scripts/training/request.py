"""What a training was asked for, from which its card and its options follow."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from ...checks import at_least
from ...envs.levels import NOMINAL
from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies import needed_options
from ...envs.policies.build import base_of
from ...envs.policies.network import CARD, WEIGHTS, Card, Residual, read_card
from ...envs.policies.trained import OBSERVATION, environment_of, training_of
from ...errors import InputError, shown
from ..extensions import import_from_here
from ..output import RunFolder, telling
from ..own_files import is_own
from ..scene import Scene
from .checkpoints import CHECKPOINT, Checkpoint
from .distillation import USUAL, distill
from .evaluations import MOTIONS, finished
from .hyperparameters import checked, hyperparameters
from .run import RENEWED, TRAINING_ONLY, learn

TASK = "ActiveSuit/ElbowFlexion-v0"
MOST_STEPS, MOST_ROWS = 10**11, 10**5
_IMPLIED = {"level": NOMINAL, "sensors": ["encoders"], "history": 1}  # a card is without these
KEPT = ("algo", "seed", "rows", "steps", "level", "motions", "patience", "teacher", *TRAINING_ONLY)


@dataclass(frozen=True, kw_only=True)
class TrainingRequest:
    """What the command was asked for.

    Attributes:
        given: Options that are given, by their names in a card.
        scene: Function that returns the scene, of the level and of the run that goes on.
        file: File of hyperparameters; None if none is given.
        resume: Whether to go on with what is there.
        trust: Whether to resume files of others.
        force: Whether to replace what is there.
        torch_threads: Number of threads of torch.
    """

    given: dict[str, Any]
    scene: partial[Scene]
    file: Path | None = None
    resume: bool = False
    trust: bool = False
    force: bool = False
    torch_threads: int = 1

    def seed(self, out: Path, seed: int) -> None:
        """Trains with a seed in a folder, or continues what is there if that is asked for.

        A training that is there with all its steps stays, if it has the same options.
        """
        resume = self.resume and (out / CHECKPOINT).exists()
        given = {**self.given, "seed": seed}
        request = replace(self, resume=resume, trust=self.trust and resume, given=given)
        if resume:
            asked, steps = training_of(out)["steps"], request._scene_and_config(out)[1]["steps"]
            if finished(out, steps):
                if steps < asked:
                    raise InputError(
                        f"--steps is {steps}, and the run in {str(out)!r} has {asked}: give at "
                        "least that, or another --out"
                    )
                return
        request.one(out)

    def one(self, out: Path) -> int:
        """Trains, or goes on, in a folder; returns the number of steps."""
        checkpoint = _check_folder(out, self.resume, self.trust, self.force)
        chosen, config = self._scene_and_config(out)
        card, options = card_and_options(chosen, config)
        folder = RunFolder(out, force=self.force, resumes=(out / CARD).is_file())
        train = distill if "teacher" in config else learn
        with telling(lambda: _kept(folder)):
            return train(folder, card, options, checkpoint, self.torch_threads)

    def _scene_and_config(self, out: Path) -> tuple[Scene, dict[str, Any]]:
        """Returns task and arms, and all that describes the training in a folder."""
        before = _before(out, self.trust) if self.resume else {}
        config = _config(before, self.given, out)
        chosen = self._chosen(config, out if self.resume else None)
        if "teacher" in config:
            self._check_student()
            config = {**USUAL, **config, "algo": "dagger"}
        else:
            settings = hyperparameters(config["algo"], chosen.env, self.file)
            if before:
                own = checked(config["algo"], before.get("hyperparameters", {}), str(out))
                if self.file is not None and settings != own:
                    raise InputError(
                        f"{str(self.file)!r} has other hyperparameters than the run in "
                        f"{str(out)!r}: leave --hyperparameters out, or train another run"
                    )
                settings |= own
            usual = {"rows": settings["n_envs"], "steps": settings["n_timesteps"]}
            config = {**usual, **config, "hyperparameters": settings}
        at_least("rows", config["rows"], 1, MOST_ROWS)  # that of a file or of a run, too
        return chosen, config

    def _check_student(self) -> None:
        """Refuses options of learners, which a student of a teacher does not have."""
        given = {**self.given, "hyperparameters": self.file}
        for name in ("algo", "residual", "reward", "patience", "hyperparameters"):
            if given.get(name) is not None:
                raise InputError(
                    f"--{name} is given, and the student of a teacher has none: leave --{name} out"
                )

    def _chosen(self, config: dict[str, Any], run: Path | None) -> Scene:
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
        observation["sensors"] = _believing(observation.get("sensors", ["encoders"]))
    config.pop("level", None)
    options = {**chosen.options, **observation}
    arms = make_arms(chosen.env, 1, **options)
    plant = Plant.of(arms.episodes)
    arms.close()
    return card_of(plant, {"env": chosen.env, **options}, config, residual), options


def _check_folder(out: Path, resume: bool, trust: bool, force: bool) -> Checkpoint | None:
    """Returns the checkpoint to go on from; None for a new run."""
    if resume:
        return Checkpoint.read(out, trust=trust)
    if force:
        return None
    if (out / CHECKPOINT).exists():
        raise InputError(
            f"{str(out)!r} holds a trained run: add --resume to go on, --force to begin anew, or "
            "choose another --out"
        )
    if (out / WEIGHTS).exists():
        raise InputError(
            f"{str(out)!r} holds a trained policy: add --force to replace it, or choose another "
            "--out"
        )
    return None


def _before(out: Path, trust: bool) -> dict[str, Any]:
    """Returns what the card of a run says of it."""
    found = {**environment_of(out), **training_of(out)}
    residual = read_card(out).residual
    if residual is not None:
        base_of(residual)
        found["residual"] = residual
    for name in ("reward", "teacher"):  # both may be of a module
        if name not in found:
            continue
        if not (trust or is_own((out / CARD).read_bytes())):
            raise InputError(
                f"the run in {str(out)!r} needs the {name} {shown(found[name])}, and its {CARD} is "
                "not of this machine: add --trust if you trust whoever made it"
            )
        import_from_here()
    return found


def _config(before: dict[str, Any], given: dict[str, Any], out: Path) -> dict[str, Any]:
    """Returns algo, seed and so on: those of the run before, which stay, those given, the usual."""
    if "belief" in given and "sensors" in given:
        given = {**given, "sensors": _believing(given["sensors"])}
    for name, value in given.items():
        old = before.get(name, _IMPLIED.get(name))
        if before and name not in RENEWED and old != value:
            other = "without" if old is None else f"with {shown(old)}"
            raise InputError(
                f"this command has --{name} {shown(value)}, and the run in {str(out)!r} was "
                f"trained {other}: leave --{name} out, or train another run"
            )
    names = (*KEPT, "residual", *OBSERVATION)
    found = {name: before[name] for name in names if name in before}
    return {"algo": "ppo", "seed": 0, "motions": MOTIONS, **found, **given}


def _believing(sensors: list[str]) -> list[str]:
    """Returns sensor suites with that of a belief."""
    return [*sensors, *({"belief"} - {*sensors})]


def _kept(folder: RunFolder) -> str:
    if (folder / CHECKPOINT).exists():
        return f"the last checkpoint is kept in {folder.path}; go on with --resume"
    return "nothing was learned yet; start the training again"
