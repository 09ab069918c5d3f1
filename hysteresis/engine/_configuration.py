"""Sets an instance up from its MJCF config: its model, its word, and its numbers in a state.

`mjData.plugin_state` holds the physical state of an instance: fault flag, memory, parameters
(radians), the elastic polynomial, the range, the viscoelastic part and the play. These numbers are
saved, copied and batched with the rest of the state, and may differ between simulations. The word
of an instance has the ids of joint and sensors, and which parts there are. A state may be set on
any MuJoCo model: ids and sizes come from the model at hand.

A batch makes thousands of mjData from one config, so models and numbers are kept by the config.
"""

import ctypes
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError, shown
from ..around import Asymmetric, Backlash, Clipped, Parts, Viscoelastic, parts
from ..around import backlash_kernels as backlash
from ..protocol import ConfigKey, HysteresisModel, State, follow, read_only
from ..safety import require_certificate
from . import native
from .native import Instance

FAULT, MEMORY = 0, 1
OFF = 2.0  # flag of an instance that is taken off and gives no torque
COMMON_KEYS = tuple(
    "joint start_angle start_torque start_path polynomial angle_range viscoelastic gap "
    "allow_uncertified taken_off".split()
)
"""Config keys of every model; the model's own keys follow."""

# A pointer-sized word holds four ids of 14 bits, the length of the polynomial (3 bits), whether the
# torque is constant outside a range, whether there is a viscoelastic part and whether there is play
# (1 bit each).
BITS, LARGEST = 14, 2**14 - 1
SENSORS = "torque", "stiffness", "energy"  # endings of the names of sensors, after the joint
POLYNOMIAL_SHIFT, HELD_SHIFT, VISCOELASTIC_SHIFT = 4 * BITS, 4 * BITS + 3, 4 * BITS + 4
PLAY_SHIFT = 4 * BITS + 5
JOINT_TYPES = 2, 3  # mjJNT_SLIDE, mjJNT_HINGE


def key_names(kind: type[HysteresisModel]) -> tuple[str, ...]:
    """Returns the names of all config keys of a kind of model."""
    return *COMMON_KEYS, *(key.name for key in kind.config_keys)


@lru_cache(maxsize=256)
def model_of(kind: type[HysteresisModel], raw: bytes) -> HysteresisModel:
    """Returns the model of a config, with all models around it."""
    config = native.config_of(key_names(kind), raw)
    model: HysteresisModel = kind.from_config(
        {key.name: _value(key, config) for key in kind.config_keys}
    )
    if limits := native.numbers(config, "angle_range"):
        model = Clipped(model=model, angle_range=limits)  # type: ignore[arg-type]
    if polynomial := native.numbers(config, "polynomial"):
        model = Asymmetric(model=model, polynomial=polynomial)
    if config["gap"]:
        model = Backlash(model=model, gap=native.number(config, "gap"))
    if rates := native.numbers(config, "viscoelastic"):
        if len(rates) != len(Viscoelastic.units):
            raise InputError(
                f"viscoelastic is {shown(config['viscoelastic'])}: give damping, relaxation "
                "stiffness and relaxation time, three numbers"
            )
        model = Viscoelastic(model=model, **dict(zip(Viscoelastic.units, rates, strict=True)))
    return model


def _value(key: ConfigKey, config: Mapping[str, str]) -> Any:
    """Returns the value of one of a model's own keys."""
    given = config[key.name].strip()
    if key.kind == "word":
        return given or key.words[0] if key.optional else given
    if key.kind == "number":
        return 0.0 if key.optional and not given else native.number(config, key.name)
    found = native.numbers(config, key.name)
    if not found and not key.optional:
        raise InputError(f"{key.name} is {shown(given)}: give at least one number")
    return key.nested(found)


@lru_cache(maxsize=1024)
def begun(kind: type[HysteresisModel], raw: bytes, reference: float) -> Array:
    """Returns an instance's numbers in a state after a reset, where qpos0 is `reference`."""
    config, model = native.config_of(key_names(kind), raw), model_of(kind, raw)
    angle, torque = (
        native.number(config, key) if config[key].strip() else default
        for key, default in (("start_angle", reference), ("start_torque", 0.0))
    )
    start, path = model.start(angle, torque), native.numbers(config, "start_path")
    if not _flag(config, "allow_uncertified"):
        require_certificate(model, start, config["joint"])
    fault = OFF if _flag(config, "taken_off") else 0.0
    return read_only(state_of(parts(model), follow(model, start, path), fault))


def _flag(config: Mapping[str, str], key: str) -> bool:
    """Returns whether a key is true; without a text it is not."""
    if config[key] not in ("", "true", "false"):
        raise InputError(f"{key} is {shown(config[key])}: use true or false")
    return config[key] == "true"


def state_of(split: Parts, state: State, fault: float = 0.0) -> Array:
    """Returns an instance's numbers in a state, from the parts of its model and their state."""
    bare, *around = split
    if split.gap.size:
        split.gap[backlash.END] = state.memory[-1]
    memory = state.memory[: bare.memory_size]
    return np.concatenate(([fault], memory, bare.parameter_vector, *around))


def size_of(model: HysteresisModel) -> int:
    """Returns how many numbers of a state an instance needs."""
    bare, *around = parts(model)
    sizes = bare.memory_size, bare.parameter_vector.size, *(part.size for part in around)
    return MEMORY + sum(sizes)


def connect(kind: type[HysteresisModel], instance: Instance) -> int:
    """Returns the word of an instance: the ids of its joint and sensors, and its parts."""
    joint = instance.find("joint", "joint")
    if instance.integer("jnt_type", joint) not in JOINT_TYPES:
        raise InputError("the joint is not a hinge or a slide joint; name a hinge or a slide")
    _require_alone(instance)
    word = native.pack([joint, *instance.sensors(SENSORS)], BITS) - 1  # the joint counts from 0
    begun(kind, instance.raw, reference_of(instance, word))
    return word | _parts_in_word(kind, instance.raw)


@lru_cache(maxsize=256)
def _parts_in_word(kind: type[HysteresisModel], raw: bytes) -> int:
    """Returns the bits of the parts around a model."""
    _, polynomial, limits, rate, play = parts(model_of(kind, raw))
    word = polynomial.size << POLYNOMIAL_SHIFT | (limits.size > 0) << HELD_SHIFT
    return word | (rate.size > 0) << VISCOELASTIC_SHIFT | (play.size > 0) << PLAY_SHIFT


def reference_of(instance: Instance, word: int) -> float:
    """Returns the reference position of an instance's joint."""
    address = instance.integer("jnt_qposadr", word & LARGEST)
    return ctypes.c_double.from_address(instance.model.qpos0 + 8 * address).value


def _require_alone(instance: Instance) -> None:
    """Checks that no earlier instance resists the same joint, unless one is taken off."""
    own = instance.raw.partition(b"\0")[0]
    for number in range(instance.number):
        other = instance.sibling(number)
        if not (other.raw.partition(b"\0")[0] == own and is_hysteretic(other)):
            continue
        if not any(_flag(one.config, "taken_off") for one in (instance, other)):
            raise InputError(
                "another instance resists the joint already; give each joint one, and take the "
                "others off"
            )


def is_hysteretic(instance: Instance) -> bool:
    """Returns whether an instance has a hysteresis plugin."""
    return instance.plugin.keys[: len(COMMON_KEYS)] == COMMON_KEYS
