"""Run folders as `activesuit train` leaves them, made without training; some by an enemy."""

import base64
import json
import pickle
import zipfile
from pathlib import Path

import gymnasium

CONFIG = {
    "env": "ActiveSuit/ElbowFlexion-v0",
    "algo": "ppo",
    "seed": 0,
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


def make_run(folder: Path, algo="ppo", **config) -> Path:
    """Makes the folder of a run whose network has not learned anything."""
    folder.mkdir()
    write_config(folder, algo=algo, **config)
    small = {"sac": {"buffer_size": 100}, "ppo": {"n_steps": 64}}[algo]
    learner(algo, **small).save(folder / "model.zip")
    return folder


def write_config(folder: Path, **config) -> None:
    """Writes config.json with some options of its own."""
    (folder / "config.json").write_text(json.dumps({**CONFIG, **config}))


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
    """Puts a pickled object into the weights."""
    import torch

    path = folder.with_name(f"{folder.name}.pth")
    torch.save({"weights": Enemy(trap)}, path)
    replace_part(folder / "model.zip", "policy.pth", path.read_bytes())


def poison_replay(folder: Path, trap: Path) -> None:
    """Makes the experience a pickled object."""
    (folder / "replay.pkl").write_bytes(pickle.dumps(Enemy(trap)))
