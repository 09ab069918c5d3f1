"""`activesuit export`: writes a trained policy as an ONNX model (needs the extra `onnx`)."""

from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from ...envs.policies import POLICIES
from ...envs.policies.network import read_card, read_network
from ...envs.policies.trained import folder_of
from ...errors import InputError, shown
from ...files import check_target, replacing
from ..options import Force
from ..output import say

TOLERANCE = 1e-5  # largest difference between the model's outputs and those of the network


def export(
    policy: Annotated[Path, tyro.conf.Positional],
    /,
    onnx: bool = False,
    out: Path = Path("policy.onnx"),
    force: Force = False,
) -> None:
    """Export a trained policy as an ONNX model, which other runtimes run.

    The model has the input observation and the output action; a network with an LSTM also has the
    input memory and the output next_memory. Its metadata says what to observe. Before the file is
    written, the outputs for 1,000 random observations are compared with those of the network.

    Args:
        policy: Name of a shipped network, or folder of a training run or of `save_policy`.
        onnx: Whether to write an ONNX model, the one format that there is (needs the extra
            activesuit[onnx]).
        out: New file of the model.
    """
    if not onnx:
        raise InputError("no format is given: add --onnx, which writes an ONNX model")
    if not policy.is_dir() and str(policy).partition(":")[0] in POLICIES:
        raise InputError(
            f"the policy {shown(str(policy))} is no network: give the folder of a training run"
        )
    folder = folder_of(str(policy)) or policy
    card = read_card(folder)
    if card.residual is not None:
        raise InputError(
            f"the network of {shown(str(policy))} corrects the policy "
            f"{shown(card.residual.policy.get('name'))}, which is no network: export one that acts "
            "alone"
        )
    network = read_network(folder, card)
    check_target(out, force=force)
    try:
        from ...envs.policies.onnx_export import differences, onnx_model
    except ImportError as error:
        raise InputError(
            f"--onnx needs a package that is not installed ({error}): run "
            "pip install 'activesuit[onnx]'"
        ) from error
    with np.errstate(all="ignore"):  # what is too large for 32 bits differs
        model = onnx_model(card, network)
        found = differences(model, network)
    for runtime, difference in found.items():
        if not difference <= TOLERANCE:
            raise InputError(
                f"the ONNX model of {str(policy)!r} differs from its network by {difference:.1e} "
                f"({runtime}), and at most {TOLERANCE:.0e} is allowed, since its weights are too "
                "large for 32-bit numbers: train again, or use the folder itself"
            )
    with replacing(out, force=force) as scratch:
        scratch.write_bytes(model.SerializeToString())
    compared = ", ".join(f"{difference:.1e} ({runtime})" for runtime, difference in found.items())
    say(f"largest difference from the network over 1,000 random observations: {compared}")
    say(f"wrote {out}")
