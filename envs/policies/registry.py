"""The registry of policies: their classes by name, and policies that are made by name."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...checks import within
from ...errors import InputError, shown, unknown_name
from ..arm_env import ArmEnv
from ..belief import Belief
from ..interface.own_code import called, imported
from ..model import resisting_joints
from ..plant import Plant
from ..setup import DEFAULTS
from ..vector_env import ArmVectorEnv
from . import adaptive, model_based, observers, predictive, trained
from .base import Policy
from .guard import Guard
from .network import Card, Network, Residual, read_card, read_network
from .residual import LEAST_SCALE, MOST_SCALE, ResidualPolicy
from .spec import AnyPolicy, PolicySpec, parsed, typed

POLICIES: dict[str, Callable[..., Policy]] = {
    "none": model_based.NoAssist,
    "transparent": model_based.Transparent,
    "gravity": model_based.GravityCompensation,
    "feedforward": model_based.HysteresisFeedforward,
    "complement": model_based.Complement,
    "compensation": model_based.Compensation,
    "inertial": observers.Inertial,
    "adaptive": adaptive.Adaptive,
    "iterative": adaptive.IterativeLearning,
    "predictive": predictive.PredictiveSampling,
    "impedance": model_based.Impedance,
    "corrected": observers.CorrectedCompensation,
    "observer": observers.ObserverAssist,
    "disturbance-observer": observers.DisturbanceObserver,
    "oracle": model_based.Oracle,
}
_EXAMPLES = {  # policies of version 0.2 that are now examples of a user's own class
    "admittance": "admittance:Admittance",
    "amplification": "amplification:ForceAmplification",
    "oscillators": "oscillators:AdaptiveOscillators",
    "proportional": "proportional:ProportionalAssist",
    "radial-basis": "radial_basis:RadialBasisTracker",
}
GUARD = "guard"  # name of an option that every policy has
_BELIEF: dict[str, Any] = {  # options of a policy that takes a belief
    "suit": Any,
    "pressure": float | None,
    "load": float | None,
    "wearer": Any,
}


@dataclass(frozen=True, kw_only=True)
class PolicyKind:
    """The properties of a policy that follow from its name, without an environment."""

    maker: Callable[..., Policy] | None = None  # class or function; None for a trained policy
    folder: str = ""  # folder of a trained policy
    options: Mapping[str, Any] = field(default_factory=dict)  # types by name, as `maker` has them
    believes: bool = False  # whether the policy takes a `Belief`: suit, pressure, load and wearer

    @classmethod
    def of(cls, name: str, beside: Sequence[str] = ()) -> "PolicyKind":
        """Returns the kind of a name; `beside` are more names for messages; see `policy_spec`."""
        if name not in POLICIES and (folder := trained.folder_of(name)):
            return cls(folder=folder)
        maker = POLICIES.get(name) or _own_maker(name, beside)
        try:
            _, *rest = inspect.signature(maker, eval_str=True).parameters.values()  # after plant
        except Exception as error:  # no argument, or annotations that cannot be read
            raise InputError(
                f"{shown(maker)} makes no policy ({type(error).__name__}: {error}): give a class "
                "or a function whose first argument is the plant"
            ) from error
        options: dict[str, Any] = {}
        for one in rest:
            if one.name == "belief":
                options |= _BELIEF
            elif one.kind is one.KEYWORD_ONLY or one.default is not one.empty:
                usual = Any if one.default in (None, one.empty) else type(one.default)
                options[one.name] = usual if one.annotation is one.empty else one.annotation
        believes = any(one.name == "belief" for one in rest)
        return cls(maker=maker, options=options, believes=believes)

    @property
    def about(self) -> str:
        """Sentence about the policy, for lists."""
        if self.maker is None:
            return read_card(self.folder).summary or ""
        return (self.maker.__doc__ or "").partition("\n\n")[0].strip()

    @property
    def needs(self) -> dict[str, Any]:
        """Options of an environment in which the policy can act; see `needed_options`."""
        if self.maker is None:
            found = trained.environment_of(self.folder)
            return {part: found.get(part, DEFAULTS[part]) for part in trained.OBSERVATION}
        sensors = getattr(self.maker, "sensors", None)
        return {} if sensors is None else {"sensors": sensors, "normalize": False, "history": 1}


def _own_maker(name: str, beside: Sequence[str]) -> Callable[..., Policy]:
    """Returns the class or function of a user that a name means."""
    if name in _EXAMPLES:
        raise InputError(
            f"policy {name!r} is an example since version 0.3: name it "
            f"examples.controllers.{_EXAMPLES[name]} in a clone of the source repository"
        )
    if not name.partition(":")[2]:
        known = (*POLICIES, *trained.shipped_policies(), *beside)
        other = ("the folder of a training run", "package.module:Class")
        raise unknown_name("policy", name, (*known, *other))
    found: Callable[..., Policy] = imported("policy", name, "class")
    if not callable(found):
        raise InputError(f"the policy {name!r} is {shown(found)}: name a class or a function")
    return found


class OwnPolicy:
    """The policy that a user's class or function `make` returns, with errors that name the policy.

    Attributes:
        policy: The policy.
        practice: Number of rollouts in which the policy learns before it is scored.
    """

    def __init__(
        self, name: str, motors: int, make: Callable[..., Policy], *given: Any, **options: Any
    ) -> None:
        self._name, self._motors = name, motors
        self.policy = called(f"policy {name!r} cannot be made", make, *given, **options)
        for method in ("reset", "act"):
            if not callable(getattr(self.policy, method, None)):
                raise InputError(
                    f"policy {name!r} makes {shown(self.policy)}, which has no {method}(): give a "
                    "function that returns an object with reset() and act(observation)"
                )
        self.practice = getattr(self.policy, "practice", 0)

    def reset(self) -> None:
        """Clears the memory of the policy."""
        called(f"policy {self._name!r} fails in reset()", self.policy.reset)

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the action of the policy, if it is finite and has the right shape."""
        what = f"policy {self._name!r} fails in act()"
        found = called(what, lambda: np.asarray(self.policy.act(observation), np.float64))
        wanted = (*observation.shape[:-1], self._motors)
        bad = found[~np.isfinite(found)]
        if found.shape != wanted or bad.size:
            shape = f"an action of shape {found.shape}"
            raise InputError(
                f"policy {self._name!r} returns {shape if found.shape != wanted else bad[0].item()}"
                f": return finite numbers from -1 to 1 of shape {wanted}"
            )
        return found


def policy_spec(given: AnyPolicy, *, beside: Sequence[str] = (), trust: bool = False) -> PolicySpec:
    """Parses and validates the specification of a policy.

    Args:
        given: A name with or without options, such as "feedforward:suit=elbow.json,lead=0.03"; or a
            dict, such as {"name": "feedforward", "lead": 0.03}, or the path of a JSON file with
            such a dict. A dot separates nested options, as in "compensation:wearer.mass=65".
        beside: Other valid names, for the message about an unknown name.
        trust: Whether a JSON file may name "package.module:Class", whose code then runs. Otherwise
            a file may name only policies of this package and training runs.
    """
    spec = parsed(given, POLICIES, trust=trust)
    kind = PolicyKind.of(spec.name, beside)
    known = {**(_BELIEF if spec.options.get(GUARD) else {}), **kind.options, GUARD: bool}
    options = {}
    for name, value in spec.options.items():
        if kind.maker is None:
            raise InputError(f"the run in {spec.name!r} has no options: leave {name} out")
        if name not in known:
            raise unknown_name(f"option of policy {spec.name!r}", name, known)
        options[name] = typed(f"option {name} of policy {spec.name!r}", value, known[name])
    return PolicySpec(spec.name, options)


def believes(name: str) -> bool:
    """Returns whether the policy of a name takes a `Belief`; references and bounds take none."""
    return (name in POLICIES or ":" in name) and PolicyKind.of(name).believes


def is_own(given: object) -> bool:
    """Returns whether a policy, as `policy_spec` returns one, or a function is a user's code."""
    if isinstance(given, PolicySpec):
        return given.name not in POLICIES and PolicyKind.of(given.name).maker is not None
    return callable(given)


def needed_options(given: AnyPolicy) -> dict[str, Any]:
    """Returns the options of an environment in which a policy can act.

    A policy needs its sensor suites in their units; a trained policy, by name or folder, needs the
    observation of its training; a class of your own without `sensors` needs nothing.
    """
    return PolicyKind.of(policy_spec(given).name).needs


def make_policy(given: AnyPolicy, env: ArmEnv | ArmVectorEnv | Plant) -> Policy:
    """Returns a policy for an ActiveSuit environment.

    Args:
        given: A policy; see `policy_spec`.
        env: Environment in which the policy will act, single or vector, wrapped or not; or the
            plant of the environment, which is the part that a policy gets.
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
            f"{', '.join(plant.sensors)}: make the environment with sensors={list(sensors)}"
        )
    if needs and name != "none" and plant.normalized:
        raise InputError(
            f"policy {name!r} reads angles in rad, and the environment has normalize=True: use "
            "normalize=False"
        )
    options = dict(spec.options)
    guarded = options.pop(GUARD, False)
    belief = Belief(**{part: options.pop(part) for part in _BELIEF if part in options})
    plant = replace(plant, config=belief.of(plant.config))
    resisting_joints(plant.config)  # reports mistakes of the belief
    if kind.believes:
        options["belief"] = belief
    make = kind.maker if name in POLICIES else partial(OwnPolicy, name, plant.motors, kind.maker)
    policy = make(plant, **options)
    return Guard(plant, policy, belief) if guarded else policy


def network_policy(card: Card, network: Network, plant: Plant, name: str) -> Policy:
    """Returns the policy of a network and its card, with NumPy alone; `name` is for messages."""
    policy = trained.TrainedPolicy(card, network, plant, name)
    if card.residual is None:
        return policy
    return ResidualPolicy(make_policy(base_of(card.residual), plant), policy, card.residual.scale)


def residual_of(given: AnyPolicy, scale: float) -> Residual:
    """Returns a policy that a network corrects as plain data, with the content of a suit file."""
    spec = policy_spec(given)
    if spec.name not in POLICIES:
        raise unknown_name("policy that a network corrects", spec.name, POLICIES)
    within("residual scale", scale, LEAST_SCALE, MOST_SCALE)
    options = dict(spec.options)
    if isinstance(options.get("suit"), str):
        options["suit"] = trained.portable(options["suit"])
    return Residual(policy={"name": spec.name, **options}, scale=scale)


def base_of(residual: Residual) -> PolicySpec:
    """Returns the policy that a network corrects; only policies of this package are allowed."""
    name = residual.policy.get("name")
    if name not in POLICIES:
        raise unknown_name("policy that a network corrects", str(name), POLICIES)
    trained.check_portable(residual.policy.get("suit"))
    return policy_spec(residual.policy)


def _plant_of(env: ArmEnv | ArmVectorEnv | Plant) -> Plant:
    if isinstance(env, Plant):
        return env
    arm = getattr(env, "unwrapped", env)
    if not isinstance(arm, ArmEnv | ArmVectorEnv):
        raise InputError(f"{shown(arm)} is no ActiveSuit environment: give one of ActiveSuit/...")
    return Plant.of(arm.episodes)
