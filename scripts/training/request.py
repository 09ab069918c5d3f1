"""The request for a training, from which card and options follow."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...checks import at_least
from ...envs.domain.levels import NOMINAL
from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies import needed_options
from ...envs.policies.network import CARD, Card, read_card
from ...envs.policies.registry import base_of
from ...envs.policies.saving import card_of
from ...envs.policies.trained import OBSERVATION, environment_of, training_of
from ...errors import InputError, shown
from ...text import say
from ..extensions import import_from_here
from ..folders import RunFolder
from ..output import telling
from ..own_files import is_own
from ..scene import Scene
from .distillation import USUAL, distill
from .evaluations import MOTIONS
from .hyperparameters import checked, hyperparameters
from .learner import begin_torch
from .run import CHECKPOINT, RENEWED, Run, finished, read_checkpoint, refuse_trained

TASK = "ActiveSuit/ElbowFlexion-v0"
MOST_ROWS = 10**5
_IMPLIED = {"level": NOMINAL, "sensors": ["encoders"], "history": 1}  # absent from a card


@dataclass(frozen=True, kw_only=True)
class TrainingRequest:
    """Options of the command.

    `given` has the given options by their names in a card, `scene` returns the scene for a level
    and for the run that is resumed, and `file` has hyperparameters.
    """

    given: dict[str, Any]
    scene: Callable[..., Scene]
    file: Path | None = None
    resume: bool = False
    trust: bool = False
    force: bool = False
    torch_threads: int = 1

    def seed(self, out: Path, seed: int) -> None:
        """Trains with a seed in a folder, or resumes the run in the folder on request."""
        resume = self.resume and (out / CHECKPOINT).exists()
        given = {**self.given, "seed": seed}
        replace(self, resume=resume, trust=self.trust and resume, given=given).one(out)

    def one(self, out: Path) -> None:
        """Trains or resumes in a folder; a finished training is not changed."""
        checkpoint, before = None, {}
        if self.resume:
            checkpoint, before = read_checkpoint(out, trust=self.trust), self._before(out)
        elif not self.force:
            refuse_trained(out)
        config = self._config(before, out)
        level, of = config.pop("level", None), out if self.resume else None
        chosen = self.scene(level=level, run=of, usual={"env": TASK})
        if "task" in chosen.options:
            raise InputError("--task is the file of a motion: name a task to train for")
        if chosen.options["coupling"] == "none":
            raise InputError(
                "coupling is 'none': there is no motor to train for; use rigid or cuffs"
            )
        config = self._with_usual(config, before, chosen.env, out)
        at_least("rows", config["rows"], 1, MOST_ROWS)  # also a number from a file or a run
        if before and finished(out) and all(before.get(n) == config.get(n) for n in RENEWED):
            say(f"the training in {out} is at its end: give more --steps to go on")
            return
        card, options = _card_and_options(chosen, config)
        folder = RunFolder(out, force=self.force, resumes=(out / CARD).is_file())
        run = Run(folder=folder, card=card, options=options, checkpoint=checkpoint)
        kept = f"what was learned is kept in {out}; go on with --resume"
        nothing = "nothing was learned yet; start the training again"
        with telling(lambda: kept if (out / CHECKPOINT).exists() else nothing):
            begin_torch(self.torch_threads)
            from .learn import learn  # imports Stable-Baselines3

            done = distill(run) if "teacher" in config else learn(run)
        say(
            f"trained {done} steps; compare, in this task and with these options: "
            f"activesuit evaluate --policies none {out}"
        )

    def _before(self, out: Path) -> dict[str, Any]:
        """Returns the options of training and observation in the card of a run."""
        seen, found, residual = environment_of(out), training_of(out), read_card(out).residual
        for name in {"reward", "teacher"} & found.keys():  # may name a module
            if not (self.trust or is_own((out / CARD).read_bytes())):
                raise InputError(
                    f"the run in {str(out)!r} needs the {name} {shown(found[name])}, and its "
                    f"{CARD} is not of this machine: add --trust if you trust whoever made it"
                )
            import_from_here()
        if residual is not None:
            base_of(residual)  # refuses a wrong policy
            found["residual"] = residual
        return found | {name: seen[name] for name in (*OBSERVATION, "level") if name in seen}

    def _config(self, before: dict[str, Any], out: Path) -> dict[str, Any]:
        """Returns the options of the earlier run, which may not change, and the given options."""
        given = dict(self.given)
        if "belief" in given and "sensors" in given:
            given["sensors"] = _believing(given["sensors"])
        for name, value in given.items():
            old = before.get(name, _IMPLIED.get(name))
            if before and name not in RENEWED and old != value:
                other = "without" if old is None else f"with {shown(old)}"
                raise InputError(
                    f"this command has --{name} {shown(value)}, and the run in {str(out)!r} was "
                    f"trained {other}: leave --{name} out, or train another run"
                )
        least = before.get("steps", 1)
        if given.get("steps", least) < least:
            raise InputError(
                f"--steps is {given['steps']}, and the run in {str(out)!r} has {least}: give at "
                "least that, or another --out"
            )
        return {"algo": "ppo", "seed": 0, "motions": MOTIONS, **before, **given}

    def _with_usual(
        self, config: dict[str, Any], before: dict[str, Any], env: str, out: Path
    ) -> dict[str, Any]:
        """Returns all options of the training, with hyperparameters or the numbers of a student."""
        if "teacher" in config:
            given = {**self.given, "hyperparameters": self.file}
            for name in ("algo", "residual", "reward", "patience", "hyperparameters"):
                if given.get(name) is not None:
                    raise InputError(
                        f"--{name} is given, and the student of a teacher has none: leave --{name} "
                        "out"
                    )
            return {**USUAL, **config, "algo": "dagger"}
        settings = hyperparameters(config["algo"], env, self.file)
        if before:
            own = checked(config["algo"], before.get("hyperparameters", {}), str(out))
            if self.file is not None and settings != own:
                raise InputError(
                    f"{str(self.file)!r} has other hyperparameters than the run in {str(out)!r}: "
                    "leave --hyperparameters out, or train another run"
                )
            settings |= own
        usual = {"rows": settings["n_envs"], "steps": settings["n_timesteps"]}
        return {**usual, **config, "hyperparameters": settings}


def _card_and_options(chosen: Scene, config: dict[str, Any]) -> tuple[Card, dict[str, Any]]:
    """Returns the card of a policy, and the options of its environment."""
    seen = {name: config[name] for name in OBSERVATION if name in config}
    others = (*seen, "residual", "done")
    training = {name: one for name, one in sorted(config.items()) if name not in others}
    residual = config.get("residual")
    if residual is not None and "sensors" not in seen:
        seen["sensors"] = list(needed_options(base_of(residual))["sensors"])
    if "belief" in seen:
        seen["sensors"] = _believing(seen.get("sensors", ["encoders"]))
    options = {**chosen.options, **seen}
    arms = make_arms(chosen.env, 1, **options)
    plant = Plant.of(arms.episodes)
    arms.close()
    return card_of(plant, {"env": chosen.env, **options}, training, residual), options


def _believing(sensors: list[str]) -> list[str]:
    """Returns sensor suites with the suite "belief"."""
    return [*sensors, *({"belief"} - {*sensors})]
