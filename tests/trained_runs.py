"""Run folders as `activesuit train` leaves them, made without training; some by an enemy."""

import base64
import hashlib
import json
import pickle
import zipfile
from pathlib import Path

import gymnasium
from activesuit.envs.policies.network import (
    CARD,
    WEIGHTS,
    Card,
    Network,
    card_file,
    contract_of,
    files_of,
)
from activesuit.envs.policies.saving import network_of

ENVIRONMENT = {
    "env": "ActiveSuit/ElbowFlexion-v0",
    "suit": "mock-suit",
    "pressure": None,
    "gravity": "moon",
    "wearer": {"stature": 1.78, "mass": 80.0, "sex": "male", "strength": 50.0},
    "coupling": "rigid",
    "payload": {"mass": 2.0},
    "side": "right",
    "tilt": [0.0, 0.0],
    "allow_uncertified": False,
}
TRAINING = {"algo": "ppo", "seed": 0, "rows": 1, "steps": 64, "hyperparameters": {"n_steps": 64}}
LAYOUT = {"angle": [0, 4], "rate": [4, 8], "motor_torque": [8, 10], "previous_action": [10, 12]}
OBSERVATION = {"sensors": ["encoders"], "normalize": False, "layout": LAYOUT}
OBSERVATION |= {"size": 12, "motors": 2, "dt": 0.01}


class Enemy:
    """An object that writes a file as soon as it is unpickled."""

    def __init__(self, trap: Path) -> None:
        self.trap = trap

    def __reduce__(self):
        return Path.write_text, (self.trap, "here")


def learner(algo="ppo", env="ActiveSuit/ElbowFlexion-v0", **settings):
    """Returns an untrained learner of Stable-Baselines3."""
    import stable_baselines3

    make = getattr(stable_baselines3, algo.upper())
    return make("MlpPolicy", gymnasium.make(f"activesuit:{env}"), device="cpu", **settings)


def make_run(folder: Path, algo="ppo", **options) -> Path:
    """Makes the folder of a run whose network has not learned anything."""
    small = {"sac": {"buffer_size": 100}, "ppo": {"n_steps": 64}}[algo]
    model = learner(algo, **small)
    folder.mkdir()
    model.save(folder / "model.zip")
    write_network(folder, network_of(model), algo=algo, **options)
    return folder


def write_network(folder: Path, network: Network, **options) -> None:
    """Writes a network, with a card that fits."""
    for name, content in files_of(card(**options), network).items():
        (folder / name).write_bytes(content)


def write_card(folder: Path, **options) -> None:
    """Writes a card with some options of its own."""
    (folder / CARD).write_bytes(card_file(card(**options)))


def card(**options) -> Card:
    """Returns a card with some options of its own, of the environment or of the training."""
    training = {name: options.pop(name) for name in [*options] if name in TRAINING}
    environment, training = {**ENVIRONMENT, **options}, {**TRAINING, **training}
    seen = {"observation": OBSERVATION, "contract": contract_of(OBSERVATION)}
    return Card(**seen, environment=environment, training=training)


def replace_part(path: Path, name: str, content: bytes) -> None:
    """Replaces one part of a zip file."""
    with zipfile.ZipFile(path) as archive:
        parts = {part: archive.read(part) for part in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for part, old in {**parts, name: content}.items():
            archive.writestr(part, content if part == name else old)


def poison_data(folder: Path, trap: Path) -> None:
    """Puts a pickled object under an extra key into the options of a checkpoint."""
    with zipfile.ZipFile(folder / "model.zip") as archive:
        data = json.loads(archive.read("data"))
    pickled = base64.b64encode(pickle.dumps(Enemy(trap))).decode()
    data["extra"] = {":type:": "<class 'dict'>", ":serialized:": pickled}
    replace_part(folder / "model.zip", "data", json.dumps(data).encode())


def poison_weights(folder: Path, trap: Path) -> None:
    """Makes the weights a pickled object, and the card one of them."""
    content = pickle.dumps(Enemy(trap))
    (folder / WEIGHTS).write_bytes(content)
    found = json.loads((folder / CARD).read_text())
    found["weights"] = hashlib.sha256(content).hexdigest()
    (folder / CARD).write_text(json.dumps(found))


def poison_replay(folder: Path, trap: Path) -> None:
    """Makes the experience a pickled object."""
    replace_part(folder / "model.zip", "replay.pkl", pickle.dumps(Enemy(trap)))
