"""Evaluations during a training: what the policy of each checkpoint gives to adapted wearers."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from ...arrays import Array
from ...assets import JOINTS
from ...envs.evaluation.core import REFERENCES, run
from ...envs.evaluation.relief import relief as each_relief
from ...envs.evaluation.relief import relief_interval
from ...envs.evaluation.rollout import FULL, Trace
from ...envs.evaluation.wearers import ArmLost
from ...envs.model import ASSISTED
from ...envs.plant import Plant
from ...envs.policies import Policy
from ...envs.policies.build import network_policy
from ...envs.policies.network import Card, Network
from ...envs.policies.trained import training_of
from ...json_files import modelled, read_json
from ..html.writing import PAGE
from ..output import RunFolder

EVALUATIONS = "evaluations.json"
FIRST = 20_000  # first seed; those from 10,000 are for scores after the training
MOTIONS = 8  # usual number, which is the least that an interval takes
BETTER = 0.005  # relief by which an evaluation must be better to count


class _Relief(BaseModel):
    """What the relief of a result must have."""

    value: float


class _Result(BaseModel):
    """What a result must have."""

    steps: int
    relief: _Relief | None
    success: float


class _Content(BaseModel):
    """What a file of evaluations must have."""

    references: dict[str, list[float]]
    results: list[_Result]
    finished: int = 0


class Evaluations:
    """Evaluates networks of a training on the same motions, and remembers the results.

    Args:
        folder: Folder of the run, in which the results are kept.
        card: Card of the policy, with the number of motions.
        options: Options of the environment.
        done: Steps of the training so far; results of later ones are dropped.

    Attributes:
        results: Results in the order of the training: steps, relief with its interval, success and
            what `physical` returns; relief is None where the policy loses arms.
        wanted: Whether there are motions to evaluate.
    """

    def __init__(self, folder: RunFolder, card: Card, options: dict[str, Any], done: int) -> None:
        self._folder, self._card, self._options = folder, card, options
        self._seeds = range(FIRST, FIRST + card.training["motions"])
        before = read_evaluations(folder.path) if done else {}
        self._references: dict[str, list[float]] = before.get("references", {})
        self.results = [one for one in before.get("results", []) if one["steps"] <= done]
        self.wanted = len(self._seeds) > 0

    @property
    def last_is_best(self) -> bool:
        """Whether no evaluation before the last one had more relief."""
        values = [value(one) for one in self.results]
        return values[-1] >= max(values)

    def stagnant(self, patience: int) -> bool:
        """Returns whether none of the last evaluations was better than those before.

        Args:
            patience: Number of the last evaluations.
        """
        values = [value(one) for one in self.results]
        before, last = values[:-patience], values[-patience:]
        return bool(before) and not max(last) > max(before) + BETTER  # both may be minus infinity

    def add(self, steps: int, network: Network) -> dict[str, Any]:
        """Evaluates a network; returns the result, which `write` keeps.

        Args:
            steps: Steps of the training so far.
            network: The network.
        """
        env = self._card.environment["env"]
        if not self._references:
            for name in REFERENCES:
                scored = run(name, name, env, self._seeds, **self._options).score
                self._references[name] = [float(effort) for effort in scored.effort]

        def policy(plant: Plant) -> Policy:
            peak[:] = plant.peak
            return network_policy(self._card, network, plant, "the training")

        peak = np.ones(len(ASSISTED))
        result: dict[str, Any] = {"steps": steps, "relief": None}
        try:
            found = run("trained", policy, env, self._seeds, **self._options)
        except ArmLost:
            result["success"] = 0.0
        else:
            unsuited, suited = (np.array(self._references[name]) for name in REFERENCES)
            effort = np.array(found.score.effort)
            relief = relief_interval(unsuited, suited, effort)
            if relief is not None:
                result |= {"relief": relief.to_dict()}
                result |= {"reliefs": np.asarray(each_relief(unsuited, suited, effort)).tolist()}
            result |= physical(found.traces, peak)
        self.results.append(result)
        return result

    def finish(self) -> None:
        """Notes that the training has come to its end, with the steps that it was asked for."""
        self.write(finished=self._card.training["steps"])

    def write(self, **more: int) -> None:
        """Writes all results, and more numbers by name, to the folder."""
        content = {"seeds": list(self._seeds), "references": self._references, **more}
        self._folder.json(EVALUATIONS, {**content, "results": self.results})


def value(result: Mapping[str, Any]) -> float:
    """Returns the relief of a result; minus infinity where there is none."""
    return -np.inf if result["relief"] is None else result["relief"]["value"]


def relief_text(found: Mapping[str, float] | None) -> str:
    """Returns a relief, and its interval if it has one, as "0.87 (0.80 to 0.95)"; "-" for none."""
    if found is None:
        return "-"
    interval = f" ({found['low']:.2f} to {found['high']:.2f})" if "low" in found else ""
    return f"{found['value']:.2f}{interval}"


def physical(traces: list[Trace], peak: Array) -> dict[str, float]:
    """Returns what motions were like, in physical units, as means over them.

    They are the share of successes, effort [1], tracking error [rad], the root mean squares of the
    torques of wearer and motors by joint [N·m], the greatest force of a cuff [N], and the share of
    time in which a motor is saturated.

    Args:
        traces: The motions.
        peak: Peak torque of the motors [N·m], shape (2,).
    """
    found = {"success": np.mean([trace.success for trace in traces])}
    for name in ("effort", "tracking"):
        found[name] = np.mean([trace.costs[name] for trace in traces])
    found |= _by_joint("wearer", JOINTS, [trace.human_torque for trace in traces])
    found |= _by_joint("motor", ASSISTED, [trace.assist_torque for trace in traces])
    full = [(np.abs(trace.assist_torque) >= FULL * peak).any(axis=1).mean() for trace in traces]
    found["saturated"] = np.mean(full)
    forces = [trace.cuff_force for trace in traces if trace.cuff_force is not None]
    if forces:
        found["cuff_peak"] = np.mean([np.linalg.norm(one, axis=2).max() for one in forces])
    return {name: float(mean) for name, mean in found.items()}


def _by_joint(whose: str, joints: tuple[str, ...], torques: list[Array]) -> dict[str, Any]:
    sizes = np.sqrt([np.mean(torque**2, axis=0) for torque in torques]).mean(axis=0)
    return {f"{whose}_{joint}": size for joint, size in zip(joints, sizes, strict=True)}


def read_evaluations(folder: Path) -> dict[str, Any]:
    """Returns what `Evaluations` has kept in the folder of a run; nothing where it has not."""
    path = folder / EVALUATIONS
    if not path.is_file():
        return {}
    found = read_json(path, "evaluations")
    modelled(found, _Content, str(path), "file of evaluations", "restore it, or train anew")
    return found


def finished(folder: Path, steps: int | None = None) -> bool:
    """Returns whether a training in a folder has come to its end, and was asked for so many steps.

    Its end has two files: the evaluations with a note of it, and then the report with their hash.

    Args:
        folder: Folder of the run.
        steps: Least number of steps; None for any.
    """
    ended = read_evaluations(folder).get("finished", 0) >= (steps or 1)
    return ended and (folder / PAGE).is_file()


def nothing_left(folder: Path, steps: int) -> bool:
    """Returns whether a run that has all steps has nothing to do to its end, either.

    Args:
        folder: Folder of the run.
        steps: Steps that it shall have in the end.
    """
    return training_of(folder).get("steps") != steps or finished(folder, steps)
