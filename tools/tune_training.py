"""Tunes the shipped hyperparameters: `python -m activesuit.tools.tune_training --algo ppo`.

Optuna (Akiba et al. 2019, KDD) maximizes the relief of adapted wearers in the second half of two
short trainings: a policy that acts alone, on Earth, and a correction of compensation in drawn
suits. The first half of the trials is random, and TPE chooses the others. The
trials are kept in a file, so that the same command goes on. The result
is a table in docs/measured; the shipped files are changed by hand, with its numbers.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import yaml
from joblib import Parallel, delayed

from .. import __version__
from ..files import write_text
from ..json_files import read_json
from ..scripts.commands.train import train
from ..scripts.training.evaluations import EVALUATIONS, value
from ..scripts.training.hyperparameters import hyperparameters
from .measure import FOLDER

SHOWN = 5  # trials in the table
WORST = -2.0  # relief of a training that loses arms
CASES: dict[str, dict[str, Any]] = {
    "alone": {},
    "correction": {"level": "randomized", "residual": "compensation:suit=mock-suit"},
}
ON_POLICY = ("ppo", "recurrent-ppo")


def settings_of(trial: optuna.Trial, algo: str) -> dict[str, Any]:
    """Returns the hyperparameters of a trial, in the syntax of rl-zoo3."""
    size = trial.suggest_categorical("size", [32, 64, 128])
    rate = trial.suggest_float("learning_rate", 2e-4, 2e-3, log=True)
    falling = trial.suggest_categorical("falling", [False, True])
    found: dict[str, Any] = {
        "gamma": trial.suggest_categorical("gamma", [0.9, 0.95, 0.98]),
        "learning_rate": f"lin_{rate:.3g}" if falling else float(f"{rate:.3g}"),
    }
    if algo not in ON_POLICY:
        found["tau"] = trial.suggest_categorical("tau", [0.005, 0.02])
        found["gradient_steps"] = trial.suggest_categorical("gradient_steps", [8, 16])
        found["batch_size"] = trial.suggest_categorical("batch_size", [256, 512])
        return {**found, "policy_kwargs": {"net_arch": [size] * 2}}
    found |= {
        "use_sde": True,
        "sde_sample_freq": trial.suggest_categorical("sde_sample_freq", [8, 16, 32]),
        "gae_lambda": trial.suggest_categorical("gae_lambda", [0.8, 0.9, 0.95]),
        "n_steps": trial.suggest_categorical("n_steps", [32, 64, 128]),
        "batch_size": trial.suggest_categorical("batch_size", [256, 512, 1024]),
        "n_epochs": trial.suggest_categorical("n_epochs", [5, 10]),
    }
    networks: dict[str, Any] = {"net_arch": {"pi": [size] * 2, "vf": [size] * 2}}
    if algo == "recurrent-ppo":
        found["target_kl"] = trial.suggest_categorical("target_kl", [0.01, 0.02, 0.05])
        networks = {"lstm_hidden_size": size, "net_arch": {"pi": [size], "vf": [size]}}
    networks["log_std_init"] = trial.suggest_float("log_std_init", -3.5, -1.5)
    return {**found, "policy_kwargs": networks}


def score(settings: dict[str, Any], algo: str, steps: int) -> dict[str, float]:
    """Returns the relief in the second half of a training, by the name of its case."""
    found = {}
    for name, case in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "tried.yml"
            file.write_text(yaml.safe_dump({"default": settings}), encoding="utf-8")
            run = Path(folder) / "run"
            usual = {"task": "ArmTracking", "algo": algo, "steps": steps, "hyperparameters": file}
            train(**usual, **case, out=run)
            results = read_json(run / EVALUATIONS, "evaluations")["results"]
        last = [max(WORST, value(one)) for one in results[len(results) // 2 :]]
        found[name] = float(np.mean(last))
    return found


def _done(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    """Returns the trials that have come to their end; others were stopped."""
    return study.get_trials(states=[optuna.trial.TrialState.COMPLETE])


def main() -> None:
    """Tunes one algorithm, and keeps its best trials beside the shipped hyperparameters."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--algo", default="ppo")
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--steps", type=int, default=200_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, required=True, help="SQLite file of the trials")
    given = parser.parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(
        study_name=given.algo,
        storage=f"sqlite:///{given.out}",
        load_if_exists=True,
        direction="maximize",
    )
    study.sampler = optuna.samplers.TPESampler(
        seed=len(study.trials),  # a study that goes on tries others than it has tried
        n_startup_trials=(given.trials + 1) // 2,
        constant_liar=True,
    )
    with Parallel(given.workers) as parallel:
        while len(_done(study)) < given.trials:
            trials = [study.ask() for _ in range(given.workers)]
            tried = [settings_of(trial, given.algo) for trial in trials]
            calls = (delayed(score)(one, given.algo, given.steps) for one in tried)
            scores: Any = parallel(calls)
            for trial, settings, found in zip(trials, tried, scores, strict=True):
                trial.set_user_attr("settings", settings)
                trial.set_user_attr("found", found)
                study.tell(trial, float(np.mean([*found.values()])))
                print(trial.number, found, settings, flush=True)
    shipped = hyperparameters(given.algo, "default")
    done: Any = _done(study)
    rows = [
        {
            "trial": trial.number,
            **trial.user_attrs["found"],
            "settings": trial.user_attrs["settings"],
        }
        for trial in sorted(done, key=lambda trial: trial.value, reverse=True)[:SHOWN]
    ]
    found = score(shipped, given.algo, given.steps)
    rows.append({"trial": "shipped", **found, "settings": shipped})
    options = f"--algo {given.algo} --trials {given.trials} --steps {given.steps}"
    content = {
        "command": f"python -m activesuit.tools.tune_training {options}",
        "version": __version__,
        "result": {"trials": len(done), "steps": given.steps, "rows": rows},
    }
    text = json.dumps(content, indent=1)
    write_text(FOLDER / f"hyperparameters-{given.algo}.json", f"{text}\n")


if __name__ == "__main__":
    main()
