"""Trained networks as data: arrays in a safetensors file and a card in JSON, for NumPy alone.

Neither file can run code, and neither needs torch.
"""

import hashlib
import json
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from ...arrays import Array
from ...errors import InputError, shown, unknown_name
from ...files import content_of
from ...json_files import modelled, read_json
from ..plant import Plant
from .residual import LEAST_SCALE, MOST_SCALE

CARD, WEIGHTS = "policy.json", "policy.safetensors"
FORMAT = 1
LARGEST = 50_000_000  # bytes; our networks have less than 2 MB
ACTIVATIONS: dict[str, Callable[[Array], Array]] = {
    "tanh": np.tanh,
    "relu": lambda values: np.maximum(values, 0.0),
}
LAYER, LSTM = "layer", "lstm"  # prefixes of the names of weights
LSTM_ARRAYS = (f"{LSTM}.input", f"{LSTM}.hidden", f"{LSTM}.bias")


class Residual(BaseModel):
    """A policy that a network corrects: action = policy + scale x network."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    policy: dict[str, Any]  # name of a policy of this package, and options
    scale: float = Field(ge=LEAST_SCALE, le=MOST_SCALE)


class Card(BaseModel):
    """The data of a policy beside its weights; `activation` and `squashed` are as in `Network`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal[1] = FORMAT  # version of the two files
    activation: Literal["tanh", "relu"] = "tanh"
    squashed: bool = False
    weights: str | None = None  # SHA-256 of the file of weights; None before the first checkpoint
    observation: dict[str, Any]  # observation and motors; see `observed`
    contract: str  # hash of `observation`
    environment: dict[str, Any]  # id of the environment of the training, and its options
    residual: Residual | None = None  # policy that the network corrects, and whose action it sees
    training: dict[str, Any]  # algorithm, seed, steps and other data of the training
    scores: dict[str, Any] | None = None  # evaluation during the training that chose these weights
    versions: dict[str, str] = {}  # versions of the packages of the training
    summary: str | None = None  # sentence about the policy, for lists
    license: str | None = None  # license of the weights, by its SPDX name


@dataclass(frozen=True, eq=False)
class Network:
    """A network of fully connected layers, behind at most one layer of LSTM.

    Attributes:
        weights: Arrays by name: "layer.0.weight" of shape (out, in), "layer.0.bias", and so on; of
            the LSTM "lstm.input" (4 hidden, in), "lstm.hidden" (4 hidden, hidden) and "lstm.bias"
            with the gates input, forget, cell, output one below the other, as in torch.
        activation: Name of the function between the layers.
        squashed: Whether the last layer's values pass tanh; else they are clipped to -1 and 1.
    """

    weights: Mapping[str, NDArray[np.floating[Any]]]
    activation: str = "tanh"
    squashed: bool = False

    def __post_init__(self) -> None:
        if self.activation not in [*ACTIVATIONS]:
            raise unknown_name("activation", self.activation, ACTIVATIONS)
        recurrent = any(name.startswith(f"{LSTM}.") for name in self.weights)
        known = [
            *(LSTM_ARRAYS if recurrent else ()),
            *(one for pair in self.layers for one in pair),
        ]
        for name in known:
            if name not in self.weights:
                raise InputError(f"the network has no {name}: add this array")
            _check_numbers(name, self.weights[name], 1 if name.endswith("bias") else 2)
        for name in self.weights:
            if name not in known:
                raise unknown_name("array of the network", name, known)
        size, gates = self.inputs, 4 * self.hidden
        shapes: dict[str, tuple[int, ...]] = {}
        if gates:
            shapes |= dict(
                zip(LSTM_ARRAYS, ((gates, size), (gates, self.hidden), (gates,)), strict=True)
            )
            size = self.hidden
        for weight, bias in self.layers:
            before, size = size, self.weights[weight].shape[0]
            shapes |= {weight: (size, before), bias: (size,)}
        for name, shape in shapes.items():
            found = self.weights[name].shape
            if found != shape:
                raise InputError(
                    f"the network's {name} has the shape {found}, and the layers before it need "
                    f"{shape}: restore its file, or train again"
                )

    @property
    def layers(self) -> list[tuple[str, str]]:
        """Names of weight and bias of each layer, of which there is at least one."""
        count = sum(
            re.fullmatch(rf"{LAYER}\..*\.weight", name) is not None for name in self.weights
        )
        return [(f"{LAYER}.{i}.weight", f"{LAYER}.{i}.bias") for i in range(max(1, count))]

    @property
    def hidden(self) -> int:
        """Size of the LSTM's state; 0 without one."""
        return self.weights[f"{LSTM}.hidden"].shape[1] if f"{LSTM}.hidden" in self.weights else 0

    @property
    def inputs(self) -> int:
        """Number of observed numbers."""
        first = f"{LSTM}.input" if f"{LSTM}.hidden" in self.weights else f"{LAYER}.0.weight"
        return self.weights[first].shape[1]

    @property
    def outputs(self) -> int:
        """Number of motors."""
        return self.weights[self.layers[-1][0]].shape[0]

    def memory(self, rows: int) -> Array:
        """Returns the memory at the begin of an episode, shape (2, rows, hidden)."""
        return np.zeros((2, rows, self.hidden))

    def act(self, observation: NDArray[np.floating[Any]], memory: Array) -> Array:
        """Returns the mean actions of rows, from -1 to 1, shape (rows, outputs).

        Args:
            observation: Observations of the rows, shape (rows, inputs).
            memory: Output and state of the LSTM, shape (2, rows, hidden), which are changed.
        """
        values = np.asarray(observation, float)
        if self.hidden:
            values = self._remembered(values, memory)
        *between, last = self.layers
        for weight, bias in between:
            values = ACTIVATIONS[self.activation](
                values @ self.weights[weight].T + self.weights[bias]
            )
        values = values @ self.weights[last[0]].T + self.weights[last[1]]
        return np.tanh(values) if self.squashed else np.clip(values, -1.0, 1.0)

    def _remembered(self, values: Array, memory: Array) -> Array:
        """Returns the output of the LSTM (Hochreiter and Schmidhuber 1997; gates as in torch)."""
        output, state = memory
        gates = values @ self.weights[f"{LSTM}.input"].T + self.weights[f"{LSTM}.bias"]
        gates += output @ self.weights[f"{LSTM}.hidden"].T
        opened, kept, new, shown = np.split(gates, 4, axis=1)
        state[:] = _sigmoid(kept) * state + _sigmoid(opened) * np.tanh(new)
        output[:] = _sigmoid(shown) * np.tanh(state)
        return output


def _sigmoid(values: Array) -> Array:
    return 0.5 * (1 + np.tanh(0.5 * values))


def _check_numbers(name: str, found: Any, dimensions: int) -> None:
    numbers = isinstance(found, np.ndarray) and found.dtype in (np.float32, np.float64)
    if not numbers or found.ndim != dimensions:
        raise InputError(
            f"the network's {name} is {shown(found)}: give an array of NumPy with {dimensions} "
            "dimensions, of the type float32 or float64"
        )
    if not np.isfinite(found).all():
        raise InputError(
            f"the network's {name} has values that are not finite: restore its file, or train again"
        )


def observed(plant: Plant) -> dict[str, Any]:
    """Returns observation and motors as plain data; a policy fits all arms with equal data."""
    return {
        "sensors": list(plant.sensors),
        "normalize": plant.normalized,
        "layout": {name: [place.start, place.stop] for name, place in plant.layout.items()},
        "size": int(np.prod(plant.observation_space.shape)),
        "motors": plant.motors,
        "dt": plant.dt,
    }


def contract_of(observation: Mapping[str, Any]) -> str:
    """Returns the hash of the data that `observed` returns."""
    text = json.dumps(observation, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def read_card(folder: str | os.PathLike[str]) -> Card:
    """Returns the card of a policy."""
    path = Path(folder) / CARD
    if not path.is_file():
        raise InputError(
            f"{str(folder)!r} is neither a policy name nor a trained policy: it has no readable "
            f"{CARD}; train it, or save one with `save_policy`"
        )
    fix = "restore it, or train again"
    card = modelled(read_json(path, "policy"), Card, str(path), "card of a policy", fix)
    if contract_of(card.observation) != card.contract:
        raise InputError(
            f"{str(path)!r} has the contract {shown(card.contract)}, which is not that of its "
            f"observation: {fix}"
        )
    return card


def read_network(folder: str | os.PathLike[str], card: Card) -> Network:
    """Returns the network of a folder; nothing in the folder is executed."""
    from safetensors import SafetensorError
    from safetensors.numpy import load

    path = Path(folder) / WEIGHTS
    if card.weights is None or not path.is_file():
        raise InputError(
            f"{str(folder)!r} has no finished {WEIGHTS}: train it first, or with --resume"
        )
    content = content_of(path, "network", LARGEST)
    if hashlib.sha256(content).hexdigest() != card.weights:
        raise InputError(
            f"{str(path)!r} and {CARD} do not belong together, since their hashes differ, and one "
            "is damaged or of another training: restore both"
        )
    try:
        network = Network(load(content), card.activation, card.squashed)
    except (SafetensorError, KeyError, ValueError, IndexError) as error:
        raise InputError(
            f"{str(path)!r} is not a readable network ({error}): restore it, or train again"
        ) from error
    size, motors = (card.observation.get(name) for name in ("size", "motors"))
    size = size + motors if card.residual and size and motors else size
    if (network.inputs, network.outputs) != (size, motors):
        raise InputError(
            f"the network in {str(folder)!r} has {network.inputs} inputs and {network.outputs} "
            f"outputs, and its card says {size} and {motors}: restore both"
        )
    return network


def files_of(card: Card, network: Network) -> dict[str, bytes]:
    """Returns the two files of a policy by name, weights first; the card's hash is filled in."""
    from safetensors.numpy import save

    content = save({name: np.ascontiguousarray(one) for name, one in network.weights.items()})
    digest = hashlib.sha256(content).hexdigest()
    changes = {"weights": digest, "activation": network.activation, "squashed": network.squashed}
    return {WEIGHTS: content, CARD: card_file(card.model_copy(update=changes))}


def card_file(card: Card) -> bytes:
    """Returns the file of a card."""
    return (card.model_dump_json(indent=1) + "\n").encode()
