"""Makes ONNX models of trained networks (needs the extra `onnx`)."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from onnx.reference import ReferenceEvaluator

from ... import __version__
from ...arrays import AnyArray
from ..interface.observation import SUITES, checked_sensors
from .network import LSTM, LSTM_ARRAYS, Card, Network

OPSET, IR_VERSION = 17, 8  # versions of 2022, which older runtimes read, too
OBSERVATIONS = 1000  # number of random observations in the check
OPERATORS = {"tanh": "Tanh", "relu": "Relu"}


def onnx_model(card: Card, network: Network) -> onnx.ModelProto:
    """Returns a trained network as an ONNX model.

    The input `observation`, shape (batch, size), gives the output `action`, shape (batch, motors).
    A network with an LSTM also has the input `memory` and the output `next_memory`, shape
    (2, batch, hidden). The card of the policy becomes the metadata of the model.
    """
    inputs = [_described("observation", ["batch", network.inputs], "See the metadata.")]
    outputs = [
        _described("action", ["batch", network.outputs], "Torque of each motor over its peak.")
    ]
    constants: dict[str, AnyArray] = {}
    nodes, values = [], "observation"
    if network.hidden:
        shape = [2, "batch", network.hidden]
        inputs.append(_described("memory", shape, "Zeros at the begin of an episode."))
        outputs.append(_described("next_memory", shape, "Memory for the next observation."))
        constants, nodes, values = _gates(network), _lstm(network.hidden), "remembered"
    for i, (weight, bias) in enumerate(network.layers):
        if i:
            nodes.append(helper.make_node(OPERATORS[network.activation], [values], [f"active.{i}"]))
            values = f"active.{i}"
        nodes.append(helper.make_node("Gemm", [values, weight, bias], [f"sum.{i}"], transB=1))
        values = f"sum.{i}"
        constants |= {name: network.weights[name].astype(np.float32) for name in (weight, bias)}
    if network.squashed:
        nodes.append(helper.make_node("Tanh", [values], ["action"]))
    else:
        constants |= {"least": np.array(-1, np.float32), "most": np.array(1, np.float32)}
        nodes.append(helper.make_node("Clip", [values, "least", "most"], ["action"]))
    arrays = [numpy_helper.from_array(one, name) for name, one in constants.items()]
    model = helper.make_model(
        helper.make_graph(nodes, "policy", inputs, outputs, arrays),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="activesuit",
        producer_version=__version__,
    )
    helper.set_model_props(model, _metadata(card))
    onnx.checker.check_model(model, full_check=True)
    return model


def differences(model: onnx.ModelProto, network: Network) -> dict[str, float]:
    """Returns the largest difference between outputs of a model and of its network, by runtime.

    Observations are random; runtimes are the reference of ONNX, and onnxruntime if installed.
    """
    runtimes: dict[str, Callable[..., Any]] = {"ONNX reference": ReferenceEvaluator(model).run}
    try:
        from onnxruntime import InferenceSession
    except ImportError:
        pass
    else:
        session = InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
        runtimes["onnxruntime"] = session.run
    rng = np.random.default_rng(0)
    observation = rng.normal(size=(OBSERVATIONS, network.inputs)).astype(np.float32)
    memory = rng.uniform(-1, 1, network.memory(OBSERVATIONS).shape).astype(np.float32)
    given, moved = {"observation": observation}, memory.astype(float)
    if network.hidden:
        given["memory"] = memory
    expected = (network.act(observation, moved), moved)[: len(given)]  # memory only with an LSTM
    found = {}
    for name, run in runtimes.items():
        pairs = zip(run(None, given), expected, strict=True)
        found[name] = float(np.max([np.abs(one - other).max() for one, other in pairs]))
    return found


def _described(name: str, shape: list[int | str], text: str) -> onnx.ValueInfoProto:
    return helper.make_tensor_value_info(name, TensorProto.FLOAT, shape, text)


def _metadata(card: Card) -> dict[str, str]:
    """Returns observation and environment of the training as JSON, and the contract's hash."""
    sensors = checked_sensors(card.observation.get("sensors", ()))
    parts = {
        part.name: {name: getattr(part, name) for name in ("shows", "unit", "limit", "scale")}
        for suite in sensors
        for part in SUITES[suite]
    }
    found = {"observation": card.observation, "parts": parts, "environment": card.environment}
    text = {name: json.dumps(one, sort_keys=True) for name, one in found.items()}
    return {**text, "contract": card.contract}


def _gates(network: Network) -> dict[str, AnyArray]:
    """Returns the numbers of the LSTM, with its gates in the order input, output, forget, cell."""
    found = {}
    for name in LSTM_ARRAYS:
        opened, kept, new, shown = np.split(network.weights[name].astype(np.float32), 4)
        found[name] = np.concatenate([opened, shown, kept, new])[None]
    bias = found[f"{LSTM}.bias"]  # ONNX adds two, of the observation and of the last output
    return {**found, f"{LSTM}.bias": np.hstack([bias, 0 * bias]), "time": np.array([0])}


def _lstm(hidden: int) -> list[onnx.NodeProto]:
    """Returns the nodes from `observation` and `memory` to `remembered` and `next_memory`."""
    return [
        helper.make_node("Unsqueeze", ["observation", "time"], ["sequence"]),
        helper.make_node("Split", ["memory"], ["output", "state"], axis=0),
        helper.make_node(
            "LSTM",
            ["sequence", *LSTM_ARRAYS, "", "output", "state"],
            ["", "next_output", "next_state"],
            hidden_size=hidden,
        ),
        helper.make_node("Concat", ["next_output", "next_state"], ["next_memory"], axis=0),
        helper.make_node("Squeeze", ["next_output", "time"], ["remembered"]),
    ]
