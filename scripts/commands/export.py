"""`activesuit export`: writes a policy as an ONNX model, or a suit or a policy as C code."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from ...assets.c_export import Part, suit_header
from ...envs.making import make_arms
from ...envs.model import ArmConfig, resisting_joints
from ...envs.model.compose import suit_of_config
from ...envs.policies import POLICIES, make_policy, needed_options, policy_spec
from ...envs.policies.c_export import exportable, policy_header
from ...envs.policies.network import read_card, read_network
from ...envs.policies.spec import is_saved
from ...envs.policies.trained import folder_of
from ...errors import InputError, install_line, shown, unknown_name
from ...files import check_target, replacing
from ...hysteresis.c_code import BYTES, identifier
from ...json_files import read_json
from ...text import say
from ..options import ENV, Force, choice, joints
from ..output import table

TOLERANCE = 1e-5  # largest difference between the model's outputs and those of the network
OF_SUITS = {"joint", "pressure", "preconditioned", "allow_uncertified"}  # options for suits
JointName = Annotated[
    str | None, choice(joints, "Joint of the suit to export.", "all joints of the suit")
]


def export(
    what: Annotated[str, tyro.conf.Positional],
    /,
    onnx: bool = False,
    c: bool = False,
    joint: JointName = None,
    out: Path | None = None,
    force: Force = False,
    **arm: Any,
) -> None:
    """Export a policy as an ONNX model, or a suit or a policy as C code for a device.

    The ONNX model has the input observation and the output action; a network with an LSTM also has
    the input memory and the output next_memory. The metadata of the model describe the observation.
    Before the file is written, the outputs of model and network are compared for 1,000 random
    observations.

    The C code is one C99 header. Its functions compute the resistance of a suit's joints at each
    new angle, or the motor torques of a policy for the angles and rates of the arm.

    Args:
        what: For --onnx: name of a shipped network, or folder of a training run or of
            `save_policy`. For --c: name or file of a suit; or a policy that cancels modelled
            torques, also with options (compensation:suit=elbow.json,lead=0.03) or as a file.
        onnx: Whether to write an ONNX model (needs the extra activesuit[onnx]).
        c: Whether to write C code.
        out: New file; by default policy.onnx, or the name of suit or policy with .h. The names of
            the C functions begin with the name of the file.
    """
    if onnx == c:
        raise InputError(
            f"{'two formats are' if onnx else 'no format is'} given: add either --onnx, which "
            "writes a network as an ONNX model, or --c, which writes a suit or a policy as C code"
        )
    given = {"joint": joint, **arm}
    if onnx:
        refuse(given, set(), "an ONNX model")
        export_network(Path(what), out or Path("policy.onnx"), force)
    elif is_policy(what):
        refuse(given, {*given} - {"joint"}, "a policy")
        export_policy(what, arm, out, force)
    else:
        refuse(given, OF_SUITS, "a suit")
        export_suit(what, joint, arm, out, force)


def is_policy(what: str) -> bool:
    """Returns whether a text names a policy; other texts name a suit."""
    if is_saved(what):
        content = read_json(what, "suit or policy")
        return isinstance(content, dict) and "joints" not in content and "name" in content
    return ":" in what or what in POLICIES or folder_of(what) is not None


def refuse(given: dict[str, object], known: set[str], what: str) -> None:
    """Refuses options without an effect on the exported file."""
    for name, value in given.items():
        if value is not None and name not in known:
            option = f"--{name.replace('_', '-')}"
            raise InputError(f"{option} is {shown(value)}, and {what} has none: leave it out")


def export_suit(
    what: str, joint: str | None, arm: Mapping[str, Any], out: Path | None, force: bool
) -> None:
    """Writes the joints of a suit as C code."""
    config = ArmConfig.from_dict({**arm, "suit": what, "coupling": "none"})
    suit, entries = suit_of_config(config), resisting_joints(config)
    if suit is None or not entries:
        raise InputError(f"the suit {shown(what)} resists no joint: name one that does")
    if joint is not None:
        if joint not in entries:
            raise unknown_name("joint of this suit", joint, entries)
        entries = {joint: entries[joint]}
    out = out or Path(f"{Path(what).stem}.h")
    about = [f"Resistance of the suit {suit.name}, by joint. {suit.description}"]
    text, parts = suit_header(
        entries, identifier(out.stem), about, allow_uncertified=config.allow_uncertified
    )
    write_header(text, parts, out, force)


def export_policy(what: str, arm: Mapping[str, Any], out: Path | None, force: bool) -> None:
    """Writes a policy as C code."""
    spec = policy_spec(what)
    if spec.name not in exportable():
        raise InputError(
            f"the policy {shown(what)} cannot be exported as C code: use one of "
            f"{', '.join(exportable())}"
        )
    arms = make_arms(ENV, 1, **arm, **needed_options(spec))
    policy = make_policy(spec, arms)
    arms.close()
    out = out or Path(f"{Path(what).stem if is_saved(what) else spec.name}.h")
    text, parts = policy_header(str(spec), policy, identifier(out.stem))
    write_header(text, parts, out, force)


def write_header(text: str, parts: list[Part], out: Path, force: bool) -> None:
    """Writes a header, and prints the memory of its parts."""
    with replacing(out, force=force) as scratch:
        scratch.write_text(text, encoding="ascii")
    columns = [(kind, i) for i in range(2) for kind in BYTES]
    header = [f"{('state', 'tables')[i]}\n{kind}" for kind, i in columns]
    rows = [
        [part.name, part.what, *(str(part.bytes(kind)[i]) for kind, i in columns)] for part in parts
    ]
    table("memory on the device [bytes]", ["part", "model", *header], rows)
    say(f"wrote {out}")


def export_network(policy: Path, out: Path, force: bool) -> None:
    """Writes a network as an ONNX model."""
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
            f"{install_line('onnx')} in the clone of the repository"
        ) from error
    with np.errstate(all="ignore"):  # an overflow in 32 bits shows as a difference below
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
