"""The registry of policies: their kinds by name, and policies that are made of plain data."""

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, get_type_hints

from pydantic import ConfigDict, TypeAdapter, ValidationError

from ...checks import within
from ...errors import InputError, shown, unknown_name
from ...json_files import read_json
from ..arm_env import ArmEnv
from ..belief import Belief
from ..interface.own_code import imported
from ..model import resisting_joints
from ..plant import Plant
from ..setup import DEFAULTS
from ..vector_env import ArmVectorEnv
from .adaptive import Adaptive, IterativeLearning
from .base import Policy
from .guard import Guard
from .impedance import Impedance
from .model_based import (
    Compensation,
    Complement,
    GravityCompensation,
    HysteresisFeedforward,
    NoAssist,
    Oracle,
    Transparent,
)
from .network import Card, Network, Residual, read_card, read_network
from .observers import CorrectedCompensation, DisturbanceObserver, ObserverAssist
from .own import own_policy
from .predictive import PredictiveSampling
from .residual import LEAST_SCALE, MOST_SCALE, ResidualPolicy
from .trained import (
    OBSERVATION,
    TrainedPolicy,
    check_portable,
    environment_of,
    folder_of,
    portable,
    shipped_policies,
)

POLICIES: dict[str, Callable[..., Policy]] = {
    "none": NoAssist,
    "transparent": Transparent,
    "gravity": GravityCompensation,
    "feedforward": HysteresisFeedforward,
    "complement": Complement,
    "compensation": Compensation,
    "adaptive": Adaptive,
    "iterative": IterativeLearning,
    "predictive": PredictiveSampling,
    "impedance": Impedance,
    "corrected": CorrectedCompensation,
    "observer": ObserverAssist,
    "disturbance-observer": DisturbanceObserver,
    "oracle": Oracle,
}
_EXAMPLES = {  # policies of version 0.2 that are examples of a class of one's own
    "admittance": "admittance:Admittance",
    "amplification": "amplification:ForceAmplification",
    "oscillators": "oscillators:AdaptiveOscillators",
    "proportional": "proportional:ProportionalAssist",
    "radial-basis": "radial_basis:RadialBasisTracker",
}
_FIXES: dict[Any, str] = {
    int: "give a whole number",
    float: "give a number",
    float | None: "give a number",
    bool: "use true or false",
}
GUARD = "guard"  # name of an option that every policy has
SAVED = ".json"  # suffix of files with a policy
_BELIEF: dict[str, Any] = {
    "suit": Any,
    "pressure": float | None,
    "load": float | None,
    "wearer": Any,
}


@dataclass(frozen=True)
class PolicySpec:
    """A policy as plain data: which one, and what differs from its usual options.

    Attributes:
        name: Name among `POLICIES` or `shipped_policies`, the folder of a training run, or
            "package.module:Class" for a class of your own.
        options: Values of its options by name.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        if not self.options:
            return self.name
        return f"{self.name}:" + ",".join(f"{name}={given}" for name, given in _flat(self.options))

    def to_dict(self) -> dict[str, Any]:
        """Returns plain values: the name and the options beside it."""
        return {"name": self.name, **self.options}


AnyPolicy = str | Mapping[str, Any] | PolicySpec
"""A policy by its name, as "name:option=value,option=value", or as a dict of name and options."""


def policy_spec(given: AnyPolicy, *, beside: Sequence[str] = (), trust: bool = False) -> PolicySpec:
    """Parses and validates the specification of a policy.

    Args:
        given: A name with or without options, such as "feedforward:suit=elbow.json,lead=0.03"; or a
            dict, such as {"name": "feedforward", "lead": 0.03}, or a JSON file of one. Fields of a
            field have a dot between them, as in "compensation:wearer.mass=65".
        beside: Other names that may be given here, for the message about an unknown one.
        trust: Whether a JSON file may name "package.module:Class", whose code then runs. A file
            names policies of this package and training runs only if it is not trusted.

    Raises:
        InputError: There is no such policy, folder, module or option, a value is of the wrong type,
            or a file that is not trusted names code.
    """
    if isinstance(given, PolicySpec):
        spec = given
    elif isinstance(given, str):
        spec = _parsed(given, trust)
    elif isinstance(given, Mapping) and isinstance(given.get("name"), str):
        spec = PolicySpec(given["name"], {k: v for k, v in given.items() if k != "name"})
    else:
        raise InputError(
            f"the policy is {shown(given)}: give a name, such as 'compensation', or a dict with one"
        )
    kind = PolicyKind.of(spec.name, beside)
    known = {**kind.options, GUARD: bool} if kind.maker else {}
    if known and spec.options.get(GUARD):
        known = {**_BELIEF, **known}
    options = {}
    for name, value in spec.options.items():
        if not known:
            raise InputError(f"the run in {spec.name!r} has no options: leave {name} out")
        if name not in known:
            raise unknown_name(f"option of policy {spec.name!r}", name, known)
        options[name] = _typed(f"option {name} of policy {spec.name!r}", value, known[name])
    return PolicySpec(spec.name, options)


@dataclass(frozen=True, kw_only=True)
class PolicyKind:
    """What is known of a policy by its name alone, before an environment is made for it.

    Attributes:
        name: Name among `POLICIES` or `shipped_policies`, folder of a training run, or
            "package.module:Class".
        maker: Class of the policy, or a function that makes it; None for a trained one.
        folder: Folder of a trained policy; None for the others.
        options: Types of its options by name.
        believes: Whether it takes a `Belief`: its suit, pressure, load and wearer.
    """

    name: str
    maker: Callable[..., Policy] | None = None
    folder: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    believes: bool = False

    @classmethod
    def of(cls, name: str, beside: Sequence[str] = ()) -> "PolicyKind":
        """Returns the kind of a name; `beside` are other names for the message about unknown ones.

        Raises:
            InputError: There is no such policy, or a class of your own cannot be imported or used.
        """
        if name in POLICIES:
            return cls._made_by(name, POLICIES[name])
        if folder := folder_of(name):
            return cls(name=name, folder=folder)
        if name in _EXAMPLES:
            raise InputError(
                f"policy {name!r} is an example since version 0.3: name it "
                f"examples.controllers.{_EXAMPLES[name]} in a clone of the source repository"
            )
        if not name.partition(":")[2]:
            other = ("the folder of a training run", "package.module:Class")
            raise unknown_name("policy", name, (*POLICIES, *shipped_policies(), *beside, *other))
        found = imported("policy", name, "class")
        if not callable(found):
            raise InputError(f"the policy {name!r} is {shown(found)}: name a class or a function")
        return cls._made_by(name, found)

    @classmethod
    def _made_by(cls, name: str, maker: Callable[..., Any]) -> "PolicyKind":
        try:
            _, *rest = inspect.signature(maker).parameters.values()  # the first is the plant
            hints = get_type_hints(maker.__init__ if isinstance(maker, type) else maker)
        except Exception as error:  # no argument, or annotations that cannot be read
            raise InputError(
                f"{shown(maker)} makes no policy ({type(error).__name__}: {error}): give a class "
                "or a function whose first argument is the environment"
            ) from error
        options: dict[str, Any] = {}
        for one in rest:
            if one.name == "belief":
                options |= _BELIEF
            elif one.kind is one.KEYWORD_ONLY or one.default is not one.empty:
                usual = type(one.default) if one.default not in (None, one.empty) else Any
                options[one.name] = hints.get(one.name, usual)
        believes = any(one.name == "belief" for one in rest)
        return cls(name=name, maker=maker, options=options, believes=believes)

    @property
    def about(self) -> str:
        """What the policy does, in a sentence."""
        if self.maker is None:
            return read_card(self.folder).summary or ""
        return (self.maker.__doc__ or "").partition("\n\n")[0].strip()

    @property
    def needs(self) -> dict[str, Any]:
        """Options of an environment in which the policy can act; see `needed_options`."""
        if self.maker is None:
            found = environment_of(self.folder)
            return {part: found.get(part, DEFAULTS[part]) for part in OBSERVATION}
        sensors = getattr(self.maker, "sensors", None)
        return {} if sensors is None else {"sensors": sensors, "normalize": False, "history": 1}


def believes(name: str) -> bool:
    """Returns whether the policy of a name takes a `Belief`; references and bounds take none."""
    return (name in POLICIES or ":" in name) and PolicyKind.of(name).believes


def needed_options(given: AnyPolicy) -> dict[str, Any]:
    """Returns the options of an environment in which a policy can act.

    Args:
        given: A policy, which needs its sensor suites in their units; or the name or folder of a
            trained one, which needs what it was trained with; or a class of your own without
            `sensors`, which takes what there is.
    """
    return PolicyKind.of(policy_spec(given).name).needs


def make_policy(given: AnyPolicy, env: ArmEnv | ArmVectorEnv | Plant) -> Policy:
    """Returns a policy for an ActiveSuit environment.

    Args:
        given: A policy; see `policy_spec`.
        env: Environment in which the policy will act, single or vector, wrapped or not; or its
            plant, which is all of it that the policy gets.

    Raises:
        InputError: See `policy_spec`; or the environment has no motors or not the sensors that the
            policy needs, or an option is out of its range.
    """
    spec, plant = policy_spec(given), _plant_of(env)
    name, kind = spec.name, PolicyKind.of(spec.name)
    needs, sensors = kind.needs, kind.needs.get("sensors", ())
    if name != "none" and not plant.motors:
        raise InputError(
            f"policy {name!r} needs motors, and coupling is 'none': use 'rigid' or 'cuffs', or the "
            "policy 'none'"
        )
    if kind.maker is None:
        card = read_card(kind.folder)
        return network_policy(card, read_network(kind.folder, card), plant, name)
    if set(sensors) - set(plant.sensors):
        raise InputError(
            f"policy {name!r} needs the sensors {', '.join(sensors)}, and the environment has "
            f"{', '.join(plant.sensors)}: make it with sensors={list(sensors)}"
        )
    if needs and name != "none" and plant.normalized:
        raise InputError(
            f"policy {name!r} reads angles in rad, and the environment has normalize=True: make it "
            "without"
        )
    options = dict(spec.options)
    guarded = options.pop(GUARD, False)
    belief = Belief(**{part: options.pop(part) for part in _BELIEF if part in options})
    plant = replace(plant, config=belief.of(plant.config))
    resisting_joints(plant.config)  # a mistake in it is reported here
    if kind.believes:
        options["belief"] = belief
    make = kind.maker if name in POLICIES else partial(own_policy, name, kind.maker, plant.motors)
    policy = make(plant, **options)
    return Guard(plant, policy, belief) if guarded else policy


def network_policy(card: Card, network: Network, plant: Plant, name: str) -> Policy:
    """Returns the policy of a trained network, by NumPy alone.

    Args:
        card: Card of the policy.
        network: Its network.
        plant: What the policy may know of the arms.
        name: Name or folder of the policy, for messages.
    """
    trained = TrainedPolicy(card, network, plant, name)
    if card.residual is None:
        return trained
    return ResidualPolicy(make_policy(base_of(card.residual), plant), trained, card.residual.scale)


def residual_of(given: AnyPolicy, scale: float) -> Residual:
    """Returns a policy that a network shall correct as plain data, a suit file as its content."""
    spec = policy_spec(given)
    if spec.name not in POLICIES:
        raise unknown_name("policy that a network corrects", spec.name, POLICIES)
    within("residual scale", scale, LEAST_SCALE, MOST_SCALE)
    options = dict(spec.options)
    if isinstance(options.get("suit"), str):
        options["suit"] = portable(options["suit"])
    return Residual(policy={"name": spec.name, **options}, scale=scale)


def base_of(residual: Residual) -> PolicySpec:
    """Returns the policy that a network corrects, which runs no code of others."""
    name = residual.policy.get("name")
    if name not in POLICIES:
        raise unknown_name("policy that a network corrects", str(name), POLICIES)
    check_portable(residual.policy.get("suit"))
    return policy_spec(residual.policy)


def _plant_of(env: ArmEnv | ArmVectorEnv | Plant) -> Plant:
    if isinstance(env, Plant):
        return env
    arm = getattr(env, "unwrapped", env)
    if not isinstance(arm, ArmEnv | ArmVectorEnv):
        raise InputError(f"{shown(arm)} is no ActiveSuit environment: make one of ActiveSuit/...")
    return Plant.of(arm.episodes)


def is_saved(text: str) -> bool:
    """Returns whether a text names a JSON file of a policy, and not a policy with options."""
    return text.endswith(SAVED) and "=" not in text


def _parsed(text: str, trust: bool) -> PolicySpec:
    """Returns a policy from "name:option=value,...", where the name may be "module:Class"."""
    if os.path.isdir(text):
        return PolicySpec(text)
    if is_saved(text):
        found = read_json(text, "policy")
        if not isinstance(found, dict) or not isinstance(found.get("name"), str):
            raise InputError(f"{text!r} is no policy: it must be an object with a name")
        name = found.pop("name")
        if ":" in name and not os.path.isdir(name) and not trust:
            raise InputError(
                f"{text!r} names {shown(name)}, and importing that would run its code: use a file "
                "with a policy of this package or the folder of a training run, or, if you trust "
                "the file, add --trust (in Python policy_spec(file, trust=True))"
            )
        return PolicySpec(name, found)
    head, *rest = text.split(":")
    if rest and "=" not in rest[0] and head not in POLICIES:
        head, rest = f"{head}:{rest[0]}", rest[1:]
    options: dict[str, Any] = {}
    for given in filter(None, ":".join(rest).split(",")):
        name, equal, value = given.partition("=")
        if not equal:
            raise InputError(
                f"policy {text!r} has {shown(given)}: give options as option=value, with commas "
                "between them"
            )
        *outer, last = name.strip().split(".")
        place: Any = options
        for part in outer:
            place = place.setdefault(part, {}) if isinstance(place, dict) else None
        if not isinstance(place, dict):
            raise InputError(
                f"policy {text!r} has {'.'.join(outer)!r} as a value and with fields: give one"
            )
        if last in place:
            raise InputError(f"policy {text!r} has the option {name!r} twice: give it once")
        place[last] = _number(value.strip()) if outer else value.strip()
    return PolicySpec(head, options)


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _flat(options: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    found = []
    for name, value in options.items():
        if isinstance(value, Mapping):
            found += _flat(value, f"{before}{name}.")
        else:
            found.append((before + name, value))
    return found


def _typed(what: str, value: Any, kind: Any) -> Any:
    """Returns a value as the type of its option, also where it is the text of one."""
    if isinstance(value, bool) and kind in (int, float):
        raise InputError(f"{what} is {value}: give a number")
    try:
        adapter = TypeAdapter(kind, config=ConfigDict(arbitrary_types_allowed=True))
        return adapter.validate_python(value)
    except ValidationError as error:
        problem = error.errors()[0]["msg"].removeprefix("Value error, ")
        fix = _FIXES.get(kind, problem)
        raise InputError(f"{what} is {shown(value)}: {fix}") from None
