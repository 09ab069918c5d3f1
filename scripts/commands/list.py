"""`activesuit list`: lists suits, tasks or policies, or shows one of them; checks a suit."""

import math
import os
from dataclasses import asdict
from typing import Annotated

import tyro

from ...assets import Suit, SuitJoint, load_suit, suit_names
from ...assets.suit_joints import is_safe
from ...errors import InputError, unknown_name
from ...hysteresis import HysteresisModel, PoleError, UncertifiedModelError
from ...hysteresis.parameter_table import parameter_table
from ...hysteresis.safety import require_certificate
from ...text import say
from ..folders import to_json
from ..options import Json, choice, shipped_tasks
from ..options import policies as known_policies
from ..options import suits as known_suits
from ..output import table

LOSS_FACTOR = (
    "loss factor: energy that one steady cycle over the joint's range dissipates, over the work "
    "that goes into the joint in the cycle. The factor comes from the fit of the mock suit's "
    "published loops, and from no measurement of a pressurized suit. A gas alone gives all work "
    "P dV/dtheta back, and has the factor 0."
)


def suits(
    name: Annotated[str | None, choice(known_suits, usual="all"), tyro.conf.Positional] = None,
    /,
    json: Json = False,
) -> None:
    """List the shipped suits, or show and check one suit.

    If the suit is not safe to simulate, the exit code is 2.

    Args:
        name: Name of a shipped suit, or path of a suit file.
    """
    if name is None:
        _list(json)
        return
    suit = load_suit(name)
    problems = [what for joint, e in suit.joints.items() if (what := _problem(joint, e))]
    if json:
        content = {**suit.model_dump(), "safe": not problems}
        for joint, entry in suit.joints.items():
            content["joints"][joint]["certificate"] = asdict(entry.model.certificate())
            content["joints"][joint]["loss_factor"] = _loss_factor(entry)
        print(to_json(content))
    else:
        _show(suit)
    if problems:
        raise InputError(
            f"{suit.name} is not safe to simulate: {'; '.join(problems)}; or identify its curves "
            "by method certified"
        )
    if not json:
        print("Safe to simulate: no motion makes its torque infinite or gets energy out of it.")


def _list(json: bool) -> None:
    found, rows = {}, []
    for suit in map(load_suit, suit_names()):
        found[suit.name] = {
            **suit.model_dump(include={"label", "pressure_kpa", "description"}),
            "joints": [*suit.joints],
            "loss_factor": {joint: _loss_factor(entry) for joint, entry in suit.joints.items()},
        }
        joints = (joint.removesuffix("_flexion").replace("_", " ") for joint in suit.joints)
        rows.append([suit.name, suit.label or "-", ", ".join(joints), _pressure(suit)])
    if json:
        print(to_json(found))
        return
    table("suits", ["name", "label", "joints", "pressure"], rows)
    for name, about in found.items():
        say(f"{name}: {about['description']}\n")


def _show(suit: Suit) -> None:
    say(f"{suit.name}: {suit.description}\n")
    say(f"label: {suit.label or '-'}; pressure: {_pressure(suit)}\n")
    if not suit.joints:
        print("It resists no joint.")
        return
    names = {joint: joint.replace("_", "\n") for joint in suit.joints}
    header, rows = parameter_table({names[j]: entry.model for j, entry in suit.joints.items()})
    columns = [_column(entry) for entry in suit.joints.values()]
    rows += [[quantity, *(column[quantity] for column in columns)] for quantity in columns[0]]
    table("models", header, rows)
    for joint, entry in suit.joints.items():
        say(f"{joint}: {entry.source}")
    say(f"\n{LOSS_FACTOR}\n")


def _pressure(suit: Suit) -> str:
    return "unknown" if suit.pressure_kpa is None else f"{suit.pressure_kpa:g} kPa"


def _column(entry: SuitJoint) -> dict[str, str]:
    low, high = entry.range
    torques = sorted(_end_torque(entry, sample) for sample in entry.samples)
    change, factor = entry.softening, _loss_factor(entry)
    softening = "-"
    if change is not None:
        softening = f"{change.first:.3g}, {change.steady:.3g},\n{change.cycles:.3g} cycles"
    return {
        "grade": entry.grade,
        "torque of the first cycle,\nof many, falls to 1/e in": softening,
        "start [rad, N·m]": f"{entry.start_angle:.2f}, {entry.start_torque:.2f}",
        "range [rad]": f"{low:.2f} .. {high:.2f}",
        "torque at its end [N·m]": f"{_end_torque(entry, entry.model):.2f}",
        "loss factor": "-" if factor is None else f"{factor:.2f}",
        "samples": str(len(torques)),
        "their torque there [N·m]": f"{torques[0]:.2f} .. {torques[-1]:.2f}" if torques else "-",
        "certificate margin": f"{entry.model.certificate().margin:.3f}",
        "safe in its range": "yes" if is_safe(entry.model, entry.range) else "NO",
        "safe to simulate": "NO" if _problem("", entry) else "yes",
    }


def _end_torque(entry: SuitJoint, model: HysteresisModel) -> float:
    """Returns the resistance of a new joint at the end of the range [N·m]."""
    try:
        return entry.response([entry.range[1]], model)[0]
    except PoleError:
        return math.inf


def _loss_factor(entry: SuitJoint) -> float | None:
    """Returns the loss factor of a joint; None if the joint has no steady cycle."""
    try:
        return entry.steady_cycle().loss_factor
    except (InputError, PoleError):
        return None


def _problem(joint: str, entry: SuitJoint) -> str | None:
    """Returns the reason why a joint is not safe to simulate, or None."""
    try:
        start = entry.model.start(entry.start_angle, entry.start_torque)
        require_certificate(entry.model, start, joint)
    except UncertifiedModelError as error:
        return str(error)
    return None


def tasks(
    name: Annotated[str | None, choice(shipped_tasks, usual="all"), tyro.conf.Positional] = None,
    /,
    json: Json = False,
) -> None:
    """List the tasks, or describe one task.

    Args:
        name: Name of a task.
    """
    from ...envs.making import OURS
    from ...envs.tasks import TASKS  # MuJoCo takes a second to import

    if name not in (None, *TASKS):
        raise unknown_name("task", name, TASKS)
    chosen = {one: task for one, task in TASKS.items() if name in (None, one)}
    if json:
        texts = ("place", "about", "source", "rule")
        found = {
            one: {**asdict(task), "id": f"{OURS}{one}-v0"}
            | {name: getattr(task, name) for name in texts}
            for one, task in chosen.items()
        }
        print(to_json(found))
        return
    rows = [
        [f"{OURS}{one}-v0", f"{task.duration:g} s", task.place, task.about]
        for one, task in chosen.items()
    ]
    table("tasks", ["id", "duration", "place", "motion and load"], rows)
    for one, task in chosen.items():
        say(f"{one} succeeds with {task.rule}. Source: {task.source}.")


def policies(
    name: Annotated[str | None, choice(known_policies, usual="all"), tyro.conf.Positional] = None,
    /,
    json: Json = False,
) -> None:
    """List the policies, with the sensors that they need and their options.

    Args:
        name: Name of a policy, or folder of a training run.
    """
    from ...envs.evaluation import BOUNDS
    from ...envs.policies import POLICIES
    from ...envs.policies.registry import PolicyKind
    from ...envs.policies.trained import shipped_policies

    names = [*POLICIES, *shipped_policies()]
    if name is not None and name not in names and not os.path.isdir(name):
        raise unknown_name("policy", name, known_policies())
    found = {}
    for one in names if name is None else [name]:
        kind = PolicyKind.of(one)
        needed = {"sensors": [*kind.needs["sensors"]], "options": [*kind.options]}
        found[one] = {"does": kind.about, **needed}
    if json:
        print(to_json(found))
        return
    rows = [
        [one, about["does"], ", ".join(about["sensors"]), ", ".join(about["options"])]
        for one, about in found.items()
    ]
    table("policies", ["name", "does", "sensors", "options"], rows)
    say(
        "Options follow a colon, as in adaptive:suit=emu-like,forgetting=10; every policy takes "
        "guard=true."
    )
    say(f"evaluate also takes the bounds {' and '.join(BOUNDS)}, which know the whole motion.")
