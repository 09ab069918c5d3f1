"""Evaluations during a training: relief of adapted wearers by the policy of each checkpoint."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from ...arrays import Array
from ...assets import JOINTS
from ...envs.evaluation import REFERENCES
from ...envs.evaluation.relief import relief, relief_interval
from ...envs.evaluation.rollout import FULL, Trace
from ...envs.evaluation.run import Runnable
from ...envs.evaluation.run import run as run_motions
from ...envs.evaluation.wearers import ArmLost
from ...envs.model import ASSISTED
from ...envs.plant import Plant
from ...envs.policies import Policy, policy_spec
from ...envs.policies.network import Network, files_of
from ...envs.policies.registry import network_policy
from ...errors import InputError
from ...json_files import modelled, read_json
from ..output import messages
from .run import Run

EVALUATIONS = "evaluations.json"
FIRST = 20_000  # first seed; seeds from 10,000 are for scores after the training
MOTIONS = 8  # usual number, which is the least number for an interval
BETTER = 0.005  # least increase of the relief that counts as an improvement
BESIDE = ("none", "compensation")  # policies for comparison in the learning curve


class _Relief(BaseModel):
    value: float


class _Result(BaseModel):
    steps: int
    relief: _Relief | None
    success: float


class _Content(BaseModel):
    """Required content of a file of evaluations."""

    references: dict[str, list[float]]
    results: list[_Result]
    beside: dict[str, _Relief | None] = {}


class Evaluations:
    """Evaluates networks of a training on the same motions, and keeps the best policy.

    Args:
        run: The run; its folder gets the policy and the results.
        done: Steps of the training so far; results after later steps are dropped.

    Attributes:
        results: Results in the order of the training: steps, relief with its interval, success and
            the means of `_physical`; relief is None where the policy loses arms.
        beside: Relief, with its interval, of policies that do not learn, by name.
        wanted: Whether there are motions to evaluate.
    """

    def __init__(self, run: Run, done: int) -> None:
        self._run, self._card, self._env = run, run.card, run.card.environment["env"]
        self._seeds = range(FIRST, FIRST + run.card.training["motions"])
        self.wanted = len(self._seeds) > 0
        before = read_evaluations(run.folder.path) if done else {}
        self._references: dict[str, list[float]] = before.get("references", {})
        self.results = [one for one in before.get("results", []) if one["steps"] <= done]
        self.beside: dict[str, dict[str, float] | None] = before.get("beside", {})

    @property
    def last(self) -> int:
        """Steps of the training at the last evaluation; 0 before the first evaluation."""
        return self.results[-1]["steps"] if self.results else 0

    @property
    def stagnant(self) -> bool:
        """Whether the last evaluations, as many as the patience in the card, improved nothing."""
        patience = self._card.training.get("patience") or len(self.results)
        values = [value(one) for one in self.results]
        before, last = values[:-patience], values[-patience:]
        return bool(before) and not max(last) > max(before) + BETTER  # both may be minus infinity

    def add(self, steps: int, network: Network) -> dict[str, Any] | None:
        """Evaluates a network, and keeps the network if it is the best so far; returns the result.

        Without motions to evaluate, the network is kept, and there is no result.
        """
        if not self.wanted:
            self.keep(steps, network)
            return None
        result = {"steps": steps, **self.evaluated(network)}
        messages.print(_line(result))
        if value(result) >= max(map(value, self.results), default=-np.inf):
            self.keep(steps, network, result)
        self.results.append(result)
        # Written last: a training that is stopped before this line repeats the evaluation.
        content = {"seeds": [*self._seeds], "references": self._references, "beside": self.beside}
        self._run.folder.json(EVALUATIONS, {**content, "results": self.results})
        return result

    def keep(self, steps: int, network: Network, scores: dict[str, Any] | None = None) -> None:
        """Saves a network as the policy of the run folder."""
        training = {**self._card.training, "done": steps}
        card = self._card.model_copy(update={"training": training, "scores": scores})
        self._run.write(files_of(card, network))

    def evaluated(self, network: Network) -> dict[str, Any]:
        """Returns relief with its interval, success and the means of `_physical` of a network."""

        def policy(plant: Plant) -> Policy:
            peak[:] = plant.peak
            return network_policy(self._card, network, plant, "the training")

        peak = np.ones(len(ASSISTED))
        if not self._references:
            for name in REFERENCES:
                scored = run_motions(name, name, self._env, self._seeds, **self._run.options).score
                self._references[name] = [float(effort) for effort in scored.effort]
            for name in BESIDE:
                try:
                    self.beside[name] = self._relief(name, policy_spec(name))[0].get("relief")
                except InputError:  # the policy loses arms, or cannot act in this environment
                    self.beside[name] = None
        try:
            found, traces = self._relief("trained", policy)
        except ArmLost:
            return {"relief": None, "success": 0.0}
        return found | _physical(traces, peak)

    def _relief(self, name: str, given: Runnable) -> tuple[dict[str, Any], list[Trace]]:
        """Returns the relief, with its interval and by motion, and the traces of the motions."""
        found = run_motions(name, given, self._env, self._seeds, **self._run.options)
        unsuited, suited = (np.array(self._references[one]) for one in REFERENCES)
        effort = np.array(found.score.effort)
        interval = relief_interval(unsuited, suited, effort)
        if interval is None:
            return {"relief": None}, found.traces
        each = np.asarray(relief(unsuited, suited, effort)).tolist()
        return {"relief": interval.to_dict(), "reliefs": each}, found.traces


def value(result: Mapping[str, Any]) -> float:
    """Returns the relief of a result; minus infinity for a result without relief."""
    return -np.inf if result["relief"] is None else result["relief"]["value"]


def relief_text(found: Mapping[str, float] | None) -> str:
    """Returns a relief and its interval, as "0.87 (0.80 to 0.95)"; "-" stands for no relief."""
    if found is None:
        return "-"
    interval = f" ({found['low']:.2f} to {found['high']:.2f})" if "low" in found else ""
    return f"{found['value']:.2f}{interval}"


def _line(result: dict[str, Any]) -> str:
    text = "no relief, as the policy loses arms or the suit costs nothing"
    if result["relief"] is not None:
        text = f"relief {relief_text(result['relief'])}"
    return f"{result['steps']} steps: {text}, success {result['success']:.0%}"


def _physical(traces: list[Trace], peak: Array) -> dict[str, float]:
    """Returns means over motions, given the peak torque of the motors [N·m].

    The means are of the successes, the effort [1], the tracking error [rad], the root mean squares
    of the torques of wearer and motors by joint [N·m], the greatest force of a cuff [N], and the
    share of time in which a motor is saturated.
    """
    found = {"success": np.mean([trace.success for trace in traces])}
    for name in ("effort", "tracking"):
        found[name] = np.mean([trace.costs[name] for trace in traces])
    assist = [trace.assist_torque for trace in traces]
    for whose, joints, torques in (
        ("wearer", JOINTS, [trace.human_torque for trace in traces]),
        ("motor", ASSISTED, assist),
    ):
        sizes = np.sqrt([np.mean(torque**2, axis=0) for torque in torques]).mean(axis=0)
        found |= {f"{whose}_{joint}": size for joint, size in zip(joints, sizes, strict=True)}
    full = [(np.abs(torque) >= FULL * peak).any(axis=1).mean() for torque in assist]
    found["saturated"] = np.mean(full)
    forces = [trace.cuff_force for trace in traces if trace.cuff_force is not None]
    if forces:
        found["cuff_peak"] = np.mean([np.linalg.norm(one, axis=2).max() for one in forces])
    return {name: float(mean) for name, mean in found.items()}


def read_evaluations(folder: Path) -> dict[str, Any]:
    """Returns the content of the file of evaluations in a run folder; empty without the file."""
    path = folder / EVALUATIONS
    if not path.is_file():
        return {}
    found = read_json(path, "evaluations")
    modelled(found, _Content, str(path), "file of evaluations", "restore it, or train anew")
    return found
