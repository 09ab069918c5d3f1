"""Distillation: a student network learns to repeat the actions of a teacher from its own sensors.

In the first round the teacher acts. In later rounds the student acts, and the samples have the
actions that the teacher would have chosen, so that the student learns in states after its own
mistakes. Source: Ross, Gordon and Bagnell 2011, AISTATS (DAgger), here with the samples of the last
rounds in place of all samples.
"""

import io
from collections import deque
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies import make_policy, needed_options
from ...envs.policies.network import Network
from ...envs.policies.saving import layers_of
from ...envs.vector_env import ArmVectorEnv
from ...errors import InputError
from ..output import progress
from .evaluations import EVALUATIONS, Evaluations
from .learner import training_seeds, unreadable
from .report import write_report_of
from .run import CHECKPOINT, Run

USUAL: dict[str, Any] = {"rows": 64, "steps": 1_000_000}
LAYERS = (64, 64)
LAST = 5  # rounds whose samples are kept
EPOCHS, BATCH, RATE = 4, 1024, 1e-3
EVALUATED = 5  # number of evaluations of a training
Samples = tuple[NDArray[np.float32], NDArray[np.float32]]
"""Observations of a student, and the actions that the teacher chooses for the same states."""


def distill(run: Run) -> int:
    """Trains a student; returns the number of steps.

    A checkpoint is written after each round. It has the network, the optimizer and the samples,
    which suffice to continue: a round begins with new episodes and a teacher without memory, and
    all random numbers of a round follow from the seed and the number of the round.
    """
    env, training = run.card.environment["env"], run.card.training
    own = {name: training[name] for name in ("randomize",) if name in training}
    teacher, seed, rows = training["teacher"], training["seed"], training["rows"]
    lesson = _Lesson(env, {**run.options, **own}, teacher, rows)
    size = rows * lesson.periods  # steps of a round
    student = _Student(lesson.size, lesson.motors, seed)
    if run.checkpoint is not None:
        student.restore(run.checkpoint, run.folder / CHECKPOINT)
    run = run.begun(EVALUATIONS)
    evaluations = Evaluations(run, student.rounds * size)
    rounds = run.rounded(size, f"rounds of {size}") // size
    with progress(f"student of {teacher} on {env}", rounds) as bar:
        while True:
            done = student.rounds
            due = done >= rounds or (done > 0 and done % max(1, rounds // EVALUATED) == 0)
            if due and (done * size > evaluations.last or not evaluations.wanted):
                evaluations.add(done * size, student.network())
            if done >= rounds:
                break
            seeds = training_seeds(seed, rows, part=done)
            student.learn(lesson.round(student.network() if done else None, seeds))
            bar.move_to(student.rounds)
            run.write({CHECKPOINT: student.content()})
    write_report_of(run, student.rounds * size, evaluations, "student")
    return student.rounds * size


class _Lesson:
    """Rows of arms that a student and its teacher observe, each with its own sensors."""

    def __init__(self, env: str, options: dict[str, Any], teacher: str, rows: int) -> None:
        theirs = {**options, **{"history": 1}, **needed_options(teacher)}
        theirs.setdefault("sensors", options.get("sensors", ("encoders",)))
        if "belief" not in theirs["sensors"]:
            theirs.pop("belief", None)
        mine = {"sensors": ("encoders",), "history": 1, **options}
        if mine.get("normalize") or theirs.get("normalize"):
            raise InputError("student or teacher have normalize: leave --normalize out")
        if "belief" in mine and theirs.get("belief", mine["belief"]) != mine["belief"]:
            raise InputError(
                "student and teacher observe different beliefs: leave --belief.suit out"
            )
        sensors = [*dict.fromkeys((*mine["sensors"], *theirs["sensors"]))]
        frames = max(mine["history"], theirs["history"])
        both = {**mine, **theirs, "sensors": sensors, "history": frames}
        self._arms = make_arms(env, rows, **both)
        size = Plant.of(self._arms.episodes).observation_space.shape[0] // frames
        layout = self._arms.layout
        self._mine, self._theirs = (_columns(env, one, layout, size) for one in (mine, theirs))
        plant = _plant(env, theirs)
        self._teacher = make_policy(teacher, plant)
        self.periods = round(self._arms.duration / self._arms.control_dt)  # of a round
        self.size, self.motors = self._mine.size, plant.motors

    def round(self, student: Network | None, seeds: list[int]) -> Samples:
        """Returns samples of one motion in each row; without a student the teacher acts."""
        seen, wished = [], []
        observation, _ = self._arms.reset(seed=seeds)
        self._teacher.reset()
        over = np.zeros(self._arms.num_envs, np.bool_)
        for _ in range(self.periods):
            mine = observation[:, self._mine]
            wanted = self._teacher.act(observation[:, self._theirs])
            seen.append(mine[~over])
            wished.append(wanted[~over].astype(np.float32))
            action = wanted if student is None else student.act(mine, student.memory(len(mine)))
            observation, _, terminated, truncated, _ = self._arms.step(action)
            over |= terminated | truncated
        return np.concatenate(seen), np.concatenate(wished)


def _plant(env: str, options: Mapping[str, Any]) -> Plant:
    arms: ArmVectorEnv = make_arms(env, 1, **options)
    arms.close()
    return Plant.of(arms.episodes)


def _columns(
    env: str, options: Mapping[str, Any], layout: Mapping[str, slice], size: int
) -> NDArray[np.int64]:
    """Returns the columns of an observation inside an observation with more sensors and frames."""
    one = _plant(env, {**options, "history": 1})
    frame = [layout[name] for name in sorted(one.layout, key=lambda name: one.layout[name].start)]
    columns = np.concatenate([np.arange(part.start, part.stop) for part in frame])
    return np.concatenate([columns + i * size for i in range(options["history"])])


class _Student:
    """A network of two layers, its optimizer, and the samples of the last rounds."""

    def __init__(self, size: int, motors: int, seed: int) -> None:
        import torch
        from torch import nn

        torch.manual_seed(seed)
        self._seed, self.rounds = seed, 0
        sizes = (size, *LAYERS)
        layers: list[Any] = []
        for before, after in pairwise(sizes):
            layers += [nn.Linear(before, after), nn.Tanh()]
        self._layers = nn.Sequential(*layers, nn.Linear(sizes[-1], motors))
        self._optimizer = torch.optim.Adam(self._layers.parameters(), lr=RATE)
        self._kept: deque[Samples] = deque(maxlen=LAST)

    def learn(self, samples: Samples) -> None:
        """Fits the network to the actions of the teacher by least squares."""
        import torch

        torch.manual_seed(training_seeds(self._seed, 1, part=self.rounds)[0])
        self._kept.append(samples)
        self.rounds += 1
        seen, wished = (
            torch.from_numpy(np.concatenate(one)) for one in zip(*self._kept, strict=True)
        )
        for _ in range(EPOCHS):
            for batch in torch.randperm(len(seen)).split(BATCH):
                loss = ((self._layers(seen[batch]) - wished[batch]) ** 2).mean()
                self._optimizer.zero_grad()
                loss.backward()
                self._optimizer.step()

    def network(self) -> Network:
        """Returns the network for NumPy."""
        return Network(layers_of(self._layers), "tanh", squashed=False)

    def content(self) -> bytes:
        """Returns a checkpoint, without the oldest samples, which the next round replaces."""
        import torch

        kept = [*self._kept][1 - LAST :]
        found = {
            "rounds": self.rounds,
            "layers": self._layers.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "kept": [[torch.from_numpy(one) for one in pair] for pair in kept],
        }
        torch.save(found, file := io.BytesIO())
        return file.getvalue()

    def restore(self, content: bytes, path: Path) -> None:
        """Restores a checkpoint, in which only numbers are read."""
        import torch

        try:
            found = torch.load(io.BytesIO(content), weights_only=True)
            self._layers.load_state_dict(found["layers"])
            self._optimizer.load_state_dict(found["optimizer"])
            self.rounds = int(found["rounds"])
            self._kept.extend((seen.numpy(), wished.numpy()) for seen, wished in found["kept"])
        except Exception as error:  # a damaged file can raise any error
            raise unreadable(path, error) from error
