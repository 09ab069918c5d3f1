"""Trains the networks that ship in the wheel: `python -m activesuit.tools.ship NAME --out FOLDER`.

Each is the best of several seeds by its relief in the evaluations of the training, whose motions no
score uses. The same command goes on where it was stopped, and at the end writes the two files of
the policy to assets/policies.
"""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from ..envs.policies.build import residual_of
from ..envs.policies.network import CARD, WEIGHTS, card_file, read_card
from ..envs.policies.trained import SHIPPED
from ..files import replacing
from ..scripts.backends import run_all
from ..scripts.scene import scene
from ..scripts.training.evaluations import finished, read_evaluations, value
from ..scripts.training.request import TrainingRequest
from ..scripts.training.seeds import seeds_of

LICENSE = "Apache-2.0"
LEARNERS = Path(__file__).parent.parent / "docs" / "learners"
NETWORKS: dict[str, tuple[str, dict[str, Any]]] = {
    "plain-network": (
        "A network on the encoders of the last five control periods, without any model, trained by "
        "PPO.",
        {
            "level": "randomized",
            "algo": "ppo",
            "history": 5,
            "steps": 400_000,
            "hyperparameters": LEARNERS / "small_exploration.yml",
        },
    ),
    "residual-network": (
        "A network that corrects compensation with the suit mock-suit, trained by PPO.",
        {
            "level": "randomized",
            "algo": "ppo",
            "history": 5,
            "residual": residual_of("compensation:suit=mock-suit", 0.3),
            "steps": 400_000,
        },
    ),
    "recurrent-network": (
        "A network with memory on the encoders, without any model, trained by recurrent PPO.",
        {"level": "randomized", "algo": "recurrent-ppo", "steps": 1_000_000},
    ),
    "student-network": (
        "A network on the encoders of ten control periods that repeats adaptive.",
        {
            "level": "randomized",
            "teacher": "adaptive:suit=mock-suit",
            "history": 10,
            "steps": 1_000_000,
        },
    ),
}


def train(name: str, seed: int, out: Path) -> None:
    """Trains one network with one seed, or continues what is there."""
    given = dict(NETWORKS[name][1])
    file = given.pop("hyperparameters", None)
    place = partial(scene, {"task": "ArmTracking"})
    request = TrainingRequest(given=given, file=file, scene=place, resume=True, force=True)
    request.seed(out, seed)


def main() -> None:
    """Trains all seeds of one network, and ships the best."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=NETWORKS)
    parser.add_argument("--seeds", default="0-9")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, required=True, help="folder of the trainings")
    given = parser.parse_args()
    runs = {seed: given.out / given.name / f"seed-{seed}" for seed in seeds_of(given.seeds)}
    left = [(given.name, seed, path) for seed, path in runs.items() if not finished(path)]
    for _ in run_all(train, left, "loky", given.workers):
        pass
    reliefs = {}
    for seed, path in runs.items():
        results = read_evaluations(path)["results"]
        reliefs[seed] = max(map(value, results))
        print(f"seed {seed}: relief {reliefs[seed]:.3f}")
    best = max(reliefs, key=lambda seed: reliefs[seed])
    card = read_card(runs[best])
    changes: dict[str, Any] = {"summary": NETWORKS[given.name][0], "license": LICENSE}
    changes["training"] = {**card.training, "best_of_seeds": sorted(runs)}
    target = SHIPPED / given.name
    target.mkdir(parents=True, exist_ok=True)
    contents = {
        WEIGHTS: (runs[best] / WEIGHTS).read_bytes(),
        CARD: card_file(card.model_copy(update=changes)),
    }
    for file, content in contents.items():
        with replacing(target / file) as scratch:
            scratch.write_bytes(content)
    print(f"seed {best} is shipped in {target}: {sum(map(len, contents.values()))} bytes")


if __name__ == "__main__":
    main()
