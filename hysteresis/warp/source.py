"""The C code of a model as the body of a function that Warp compiles, for processors and GPUs.

The files *.c become the members of a struct. The constant tables are references into the numbers of
one world, so the functions of C read tables by name, and each world has a model of its own.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ..around import Viscoelastic
from ..c_code import Header, identifier, numbers
from ..protocol import HysteresisModel, State

TRIAL, COMMIT, BEGIN = range(3)
ANGLE, TORQUE, EXTRA = range(3)  # numbers behind the tables: where a motion begins
# Warp compiles without the C library; Warp's own functions of these names are ambiguous or missing.
MATH = """
static CUDA_CALLABLE bool isnan(float x) { return x != x; }
static CUDA_CALLABLE bool isfinite(float x) { return x - x == 0.0f; }
#ifdef __CUDA_ARCH__
static CUDA_CALLABLE float expm1f(float x) { return ::expm1f(x); }
static CUDA_CALLABLE float log1pf(float x) { return ::log1pf(x); }
static CUDA_CALLABLE float copysignf(float x, float y) { return ::copysignf(x, y); }
#else
static float expm1f(float x) { return ::fabsf(x) < 1e-7f ? x : (float)(::exp((double)x) - 1.0); }
static float log1pf(float x) { return ::fabsf(x) < 1e-7f ? x : (float)::log(1.0 + (double)x); }
static float copysignf(float x, float y) { return __builtin_copysignf(x, y); }
#endif
"""
BODY = """
#ifndef ACTIVESUIT_FLOAT
#define ACTIVESUIT_FLOAT
#endif
struct Model {{
{members}
}};
const long long place = (long long)world * memory.shape[1] + joint;
const float *number = numbers.data + ((long long)row * numbers.shape[1] + joint) * {size};
float *kept = memory.data + place * {state};
Model model = {{{tables}}};
Model::as_joint_state state;
static_assert(sizeof state == {state} * sizeof(float), "the state has floats only");
if (phase == {BEGIN}) {{
    model.as_joint_init(&state);
    *(Model::as_joint_state *)kept = state;
}} else {{
    state = *(const Model::as_joint_state *)kept;
}}
{motion}
if (phase == {COMMIT} && Model::isfinite(angle))
    *(Model::as_joint_state *)kept = state;
return wp::vec_t<2, float>(torque, beside);
"""
SLOW = """
const float torque = model.as_joint_step(&state, angle), beside = 0.0f;
"""
FAST = """
const float torque = model.{inner}_step(&state.inner, angle);
if (phase == {COMMIT} && Model::isfinite(angle))
    model.as_joint_relax(&state, angle, dt);
const float beside = model.as_joint_beside(&state, angle, rate);
"""


@dataclass
class _Members(Header):
    """A header whose tables are references into an array of numbers."""

    sizes: list[int] = field(default_factory=list)  # how many numbers each table has

    def table(self, name: str, values: Iterable[float]) -> None:
        self.sizes.append(len(list(values)))
        self.add(f"const as_real (&{name})[{self.sizes[-1]}];")

    def members(self) -> str:
        """Returns the members of the struct."""
        code = re.sub(r"^#include <.+>\n", "", "\n\n".join(self._code), flags=re.MULTILINE)
        return MATH + code.replace("static inline ", "CUDA_CALLABLE ")


@dataclass(frozen=True)
class Source:
    """The code of all models of one kind and size, and the numbers of such a model."""

    code: str  # body of a function of C++
    size: int  # how many numbers the tables have, with angle and torque at the start
    state: int  # how many numbers the memory has


def source_of(model: HysteresisModel) -> Source:
    """Returns the code of a model."""
    header = _Members("as")
    # A table leaves out zeros at the end: a memory of ones gives a table with room for any memory.
    ones = np.ones(model.memory_size)
    state = header.model("as_joint", model, State(ones, 1.0, 1.0))
    places = np.cumsum([0, *header.sizes])
    tables = ", ".join(
        f"*(const Model::as_real (*)[{size}])(number + {place})"
        for size, place in zip(header.sizes, places, strict=False)
    )
    motion = SLOW
    if isinstance(model, Viscoelastic):
        motion = FAST.format(inner=f"as_joint_{identifier(model.model.name)}", COMMIT=COMMIT)
    size = int(places[-1]) + EXTRA
    fields = {"size": size, "state": state, "tables": tables, "motion": motion}
    code = BODY.format(members=header.members(), BEGIN=BEGIN, COMMIT=COMMIT, **fields)
    return Source(code, size, state)


def row_of(model: HysteresisModel, start: State) -> list[float]:
    """Returns the numbers of a model's tables, then angle and torque of the start."""
    return [*numbers(model, start.memory.tolist()), start.angle, start.torque]
