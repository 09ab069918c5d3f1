"""Distillation: a network learns to repeat the actions of a teacher from sensors of its own.

In the first round the teacher acts, then the student acts and the teacher says what it would have
done, so that the student learns from the states that its own mistakes lead to.
Source: Ross, Gordon and Bagnell 2011, AISTATS (DAgger), with the last rounds in place of all.
"""

import io
from collections import deque
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...envs.making import make_arms
from ...envs.plant import Plant
from ...envs.policies import make_policy, needed_options
from ...envs.policies.network import Card, Network, files_of
from ...envs.vector_env import ArmVectorEnv
from ...errors import InputError, install_line
from ..output import RunFolder, messages, progress
from .checkpoints import CHECKPOINT, Checkpoint, note_missing, unreadable, write_own
from .evaluations import Evaluations, nothing_left
from .learners import threads, training_seeds
from .run import begin, end, report

USUAL: dict[str, Any] = {"rows": 64, "steps": 1_000_000}
LAYERS = (64, 64)
LAST = 5  # rounds whose samples are kept
EPOCHS, BATCH, RATE = 4, 1024, 1e-3
PAIR = ("seen", "wished")  # what a student saw, and what its teacher would have done
Samples = NDArray[np.float32]


def distill(
    folder: RunFolder,
    card: Card,
    options: dict[str, Any],
    checkpoint: Checkpoint | None,
    torch_threads: int,
) -> int:
    """Trains a student; returns the number of steps.

    There is a checkpoint after each round. A round begins with new episodes, whose seeds follow
    from its number, and with a teacher that has forgotten the last ones. So what the next rounds
    depend on is the network, its optimizer, the kept samples and the random generator of torch.

    Args:
        folder: Folder of the run.
        card: Card of the student, whose `training` has the teacher.
        options: Options of the student's environment.
        checkpoint: Checkpoint from which the training continues; None begins anew.
        torch_threads: Number of threads of torch.
    """
    try:
        import torch
    except ImportError as error:
        raise InputError(
            "a student needs torch: use `make train` in a clone of the repository, or "
            f"{install_line('train')}"
        ) from error
    env, training = card.environment["env"], card.training
    own = {name: training[name] for name in ("randomize",) if name in training}
    teacher, steps = training["teacher"], training["steps"]
    lesson = Lesson(env, {**options, **own}, teacher, training["rows"])
    size = training["rows"] * lesson.periods  # steps of a round
    rounds = max(1, round(steps / size))
    torch.manual_seed(training["seed"])
    student = _Student(lesson.size, lesson.motors)
    kept: deque[tuple[Samples, Samples]] = deque(maxlen=LAST)
    done = _go_back(student, kept, checkpoint) if checkpoint else 0  # rounds
    if done >= rounds and nothing_left(folder.path, steps):
        raise InputError(
            f"the run has {done * size} steps already, in rounds of {size}: give --steps above "
            "that to go on"
        )
    card = begin(folder, card, resume=bool(checkpoint))
    evaluations = Evaluations(folder, card, options, done * size)

    def keep_if_best(steps: int, network: Network) -> None:
        """Evaluates the student, and keeps its policy if it is the best so far."""
        scores = None
        if evaluations.wanted:
            scores = evaluations.add(steps, network)
            messages.print(report(scores))
        if scores is None or evaluations.last_is_best:
            filled = {"training": {**training, "done": steps}, "scores": scores}
            note_missing(write_own(folder, files_of(card.model_copy(update=filled), network)))
        evaluations.write()  # the last file: without it, the evaluation is done again

    def due(done: int) -> bool:
        """Returns whether there is an evaluation after some rounds, which is not done yet."""
        last = evaluations.results[-1]["steps"] if evaluations.results else 0
        fifth = done > 0 and done % max(1, rounds // 5) == 0
        return (fifth or done == rounds) and done * size > last

    with threads(torch_threads), progress(f"student of {teacher} on {env}", rounds) as bar:
        if due(done):  # stopped before it was done
            keep_if_best(done * size, student.network())
        while done < rounds:
            seeds = training_seeds(training["seed"], training["rows"], part=done)
            kept.append(lesson.round(student.network() if done else None, seeds))
            student.learn(kept)
            done += 1
            bar.move_to(done)
            note_missing(write_own(folder, {CHECKPOINT: _content(student, kept, done)}))
            if due(done):
                keep_if_best(done * size, student.network())
    end(folder, card, done * size, evaluations, "student")
    return done * size


def _content(student: "_Student", kept: deque[tuple[Samples, Samples]], rounds: int) -> bytes:
    """Returns a checkpoint after some rounds: an archive of NumPy, which holds numbers only."""
    import torch

    last = [*kept][1 - LAST :]  # the next round replaces the one before them
    content: dict[str, Any] = student.numbers() | {"random": torch.get_rng_state().numpy()}
    for i, pair in enumerate(last):
        content |= {f"{what}.{i}": one for what, one in zip(PAIR, pair, strict=True)}
    file = io.BytesIO()
    np.savez(file, rounds=rounds, **content)
    return file.getvalue()


def _go_back(
    student: "_Student", kept: deque[tuple[Samples, Samples]], checkpoint: Checkpoint
) -> int:
    """Restores what `_content` has kept; returns the number of rounds."""
    import torch

    try:
        with np.load(io.BytesIO(checkpoint.learner), allow_pickle=False) as file:
            found = dict(file)
        student.restore(found)
        rounds = int(found["rounds"])
        for i in range(min(rounds, LAST - 1)):
            seen, wished = (found[f"{what}.{i}"] for what in PAIR)
            student.check(seen, wished)
            kept.append((seen, wished))
        torch.set_rng_state(torch.from_numpy(found["random"]))
    except Exception as error:  # a damaged file fails wherever it is damaged
        raise unreadable(checkpoint.path, error) from error
    return rounds


class Lesson:
    """Rows of arms that show both a student and its teacher what each may see.

    Args:
        env: Id of the environment.
        options: Options of the student's environment.
        teacher: Specification of the teacher.
        rows: Number of rows.

    Attributes:
        periods: Number of control periods of a round.
        size: Number of values that the student observes.
        motors: Number of motors.
    """

    def __init__(self, env: str, options: dict[str, Any], teacher: str, rows: int) -> None:
        theirs = {**options, **{"history": 1}, **needed_options(teacher)}
        theirs.setdefault("sensors", options.get("sensors", ("encoders",)))
        if "belief" not in theirs["sensors"]:
            theirs.pop("belief", None)
        mine = {"sensors": ("encoders",), "history": 1, **options}
        if mine.get("normalize") or theirs.get("normalize"):
            raise InputError("student or teacher have normalize: leave --normalize out")
        if "belief" in mine and theirs.get("belief", mine["belief"]) != mine["belief"]:
            raise InputError("student and teacher observe different beliefs: leave --belief out")
        sensors = [*dict.fromkeys((*mine["sensors"], *theirs["sensors"]))]
        frames = max(mine["history"], theirs["history"])
        both = {**mine, **theirs, "sensors": sensors, "history": frames}
        self._arms = make_arms(env, rows, **both)
        size = Plant.of(self._arms.episodes).observation_space.shape[0] // frames
        layout = self._arms.layout
        self._mine, self._theirs = (_columns(env, one, layout, size) for one in (mine, theirs))
        plant = _plant(env, theirs)
        self._teacher = make_policy(teacher, plant)
        self.periods = round(self._arms.duration / self._arms.control_dt)
        self.size, self.motors = self._mine.size, plant.motors

    def round(self, student: Network | None, seeds: list[int]) -> tuple[Samples, Samples]:
        """Returns what the student saw, and what the teacher would have done, sample by sample.

        Args:
            student: Student that acts; None lets the teacher act.
            seeds: Seed of each row.
        """
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
    """Returns the places of an observation in that of arms with more sensors and frames."""
    one = _plant(env, {**options, "history": 1})
    frame = [layout[name] for name in sorted(one.layout, key=lambda name: one.layout[name].start)]
    columns = np.concatenate([np.arange(part.start, part.stop) for part in frame])
    return np.concatenate([columns + i * size for i in range(options["history"])])


class _Student:
    """A network of two layers, and what teaches it."""

    def __init__(self, size: int, motors: int) -> None:
        from torch import nn, optim

        self._shape = (size, motors)
        sizes = (size, *LAYERS)
        layers: list[Any] = []
        for before, after in pairwise(sizes):
            layers += [nn.Linear(before, after), nn.Tanh()]
        self._layers = nn.Sequential(*layers, nn.Linear(sizes[-1], motors))
        self._optimizer = optim.Adam(self._layers.parameters(), lr=RATE)

    def learn(self, kept: deque[tuple[Samples, Samples]]) -> None:
        """Moves the network towards the teacher's actions, by their squared differences."""
        import torch

        seen = torch.from_numpy(np.concatenate([one for one, _ in kept]))
        wished = torch.from_numpy(np.concatenate([one for _, one in kept]))
        for _ in range(EPOCHS):
            for batch in torch.randperm(len(seen)).split(BATCH):
                loss = ((self._layers(seen[batch]) - wished[batch]) ** 2).mean()
                self._optimizer.zero_grad()
                loss.backward()
                self._optimizer.step()

    def network(self) -> Network:
        """Returns the network as NumPy runs it."""
        from ...envs.policies.saving import layers_of

        return Network(layers_of(self._layers), "tanh", squashed=False)

    def numbers(self) -> dict[str, NDArray[Any]]:
        """Returns the numbers of the layers and of their optimizer, by name."""
        found = {f"layers.{name}": one for name, one in self._layers.state_dict().items()}
        for i, state in self._optimizer.state_dict()["state"].items():
            found |= {f"optimizer.{i}.{name}": one for name, one in state.items()}
        return {name: one.numpy() for name, one in found.items()}

    def restore(self, numbers: Mapping[str, NDArray[Any]]) -> None:
        """Restores what `numbers` has returned; other numbers raise some exception."""
        import torch

        layers = {name: f"layers.{name}" for name in self._layers.state_dict()}
        self._layers.load_state_dict(
            {name: torch.from_numpy(numbers[key]) for name, key in layers.items()}
        )
        states = {}
        for i, weights in enumerate(self._layers.parameters()):
            shapes = {"step": (), "exp_avg": weights.shape, "exp_avg_sq": weights.shape}
            states[i] = {
                name: torch.from_numpy(numbers[f"optimizer.{i}.{name}"]).reshape(shape)
                for name, shape in shapes.items()
            }
        groups = self._optimizer.state_dict()["param_groups"]
        self._optimizer.load_state_dict({"state": states, "param_groups": groups})

    def check(self, seen: Samples, wished: Samples) -> None:
        """Raises ValueError unless samples are of this student."""
        shapes = tuple((len(seen), size) for size in self._shape)
        if (seen.shape, wished.shape) != shapes:
            raise ValueError(f"samples have the shapes {seen.shape} and {wished.shape}")
