"""C99 code of models, for controllers without an operating system.

Each model has the kernel `commit` in C beside its kernels in Python, and each model around another
has a step. `Header` joins this code with the numbers of a model. In the files

    as_, AS_             begin every name, and become the name of the header
    as_NAME_commit       takes the parameters p, their number, the memory s and the angle, as the
                         kernel of Python does, without the energies; NAME is the folder of a file
                         kernels.c, or else the name of the file
    LAYER_, INNER_       begin the names of a model around another, and of the model inside
    #include "FILE"      becomes the code of FILE, once in a header
"""

import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import Array
from ..errors import InputError, one_line, shown
from .around import Viscoelastic, Wrapper, viscoelastic_kernels
from .protocol import HysteresisModel, State

WIDTH = 100  # columns
PER_LINE = 4  # numbers in a line of a table
LARGEST = 3e38  # about the largest number of 32 bits
BYTES = {"float": 4, "double": 8}
"""Bytes of a number by the type of the numbers."""


@dataclass
class Header:
    """A C99 header to which models and other code are added.

    Attributes:
        prefix: Beginning of all names in the header, of letters, digits and underscores.
        constants: How many numbers the constant tables have.
    """

    prefix: str
    constants: int = 0
    _code: list[str] = field(default_factory=list)
    _included: set[Path] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.include(Path(__file__).with_suffix(".h"))

    def include(self, path: Path) -> None:
        """Adds the code of a file, after the files that it includes; a second call adds nothing."""
        path = path.resolve()
        if path not in self._included:
            self._included.add(path)
            self.add(self._read(path))

    def add(self, code: str) -> None:
        """Adds code, in which `as_` and `AS_` stand for the prefix."""
        code = re.sub(r"\bas_", f"{self.prefix}_", code)
        self._code.append(re.sub(r"\bAS_", f"{self.prefix.upper()}_", code).strip())

    def table(self, name: str, values: Iterable[float]) -> None:
        """Adds a constant array."""
        numbers = list(map(float, values))
        self.constants += len(numbers)
        rows = [
            ", ".join(literal(value) for value in numbers[i : i + PER_LINE])
            for i in range(0, len(numbers), PER_LINE)
        ]
        lines = ",\n".join(f"    {row}" for row in rows)
        self.add(f"static const as_real {name}[{len(numbers)}] = {{\n{lines}}};")

    def model(self, name: str, model: HysteresisModel, state: State) -> int:
        """Adds a model: the type `NAME_state` and the functions `NAME_init` and `NAME_step`.

        `name` begins with `as_`, and `NAME_init` begins in `state`. Returns how many numbers the
        type `NAME_state` has.
        """
        return self._layer(name, model, state.memory.tolist())

    def _layer(self, name: str, model: HysteresisModel, memory: Sequence[float]) -> int:
        source = model.c_source
        if not source.is_file():
            raise InputError(
                f"model {model.name!r} has no C code: write {source.name} beside its "
                f"{'class' if isinstance(model, Wrapper) else 'kernels'}, as activesuit/hysteresis/"
                "c_code.py describes it"
            )
        if not isinstance(model, Wrapper):
            self.include(source)
            return self._kernels(name, model, memory)
        inner = f"{name}_{identifier(model.model.name)}"
        size = model.model.memory_size
        state = self._layer(inner, model.model, memory[:size])
        self.table(f"{name}_p", model.given)
        if size < len(memory):
            self.table(f"{name}_start", memory[size:])
        code = self._read(source).replace("LAYER_", f"{name}_").replace("INNER_", f"{inner}_")
        self.add(code)
        return state + model.c_state

    def _kernels(self, name: str, model: HysteresisModel, memory: Sequence[float]) -> int:
        path = model.c_source
        kernel = path.parent.name if path.stem == "kernels" else path.stem
        start = list(np.trim_zeros(np.array(memory), "b")) or [0.0]  # zeros need no table
        self.table(f"{name}_p", model.parameter_vector)
        self.table(f"{name}_start", start)
        self.add(
            f"""
typedef struct {{
    as_real memory[{len(memory)}];
}} {name}_state;

static inline void {name}_init({name}_state *s)
{{
    for (int i = 0; i < {len(memory)}; i++)
        s->memory[i] = i < {len(start)} ? {name}_start[i] : 0;
}}

static inline as_real {name}_step({name}_state *s, as_real angle)
{{
    return as_{kernel}_commit({name}_p, {len(model.parameter_vector)}, s->memory, angle);
}}"""
        )
        return len(memory)

    def _read(self, path: Path) -> str:
        code = path.read_text(encoding="ascii")
        for name in re.findall(r'^#include "(.+)"\n', code, re.MULTILINE):
            self.include(path.parent / name)
        return re.sub(r'^#include "(.+)"\n', "", code, flags=re.MULTILINE)

    def text(self, about: Sequence[str]) -> str:
        """Returns the header, which begins with a comment of the paragraphs `about`."""
        guard = f"{self.prefix.upper()}_H"
        parts = [comment(about), f"#ifndef {guard}\n#define {guard}", *self._code, "#endif"]
        return "\n\n".join(parts) + "\n"


def numbers(model: HysteresisModel, memory: Sequence[float]) -> list[float]:
    """Returns the numbers of a model's constant tables, in the order of the header.

    The tables of starts have the whole `memory`, with zeros at the end.
    """
    if isinstance(model, Wrapper):
        size = model.model.memory_size
        return [*numbers(model.model, memory[:size]), *model.given, *memory[size:]]
    return [*model.parameter_vector.tolist(), *memory]


def stepped(model: HysteresisModel, state: State, angle: Array, dt: float) -> Array:
    """Computes the torques of `NAME_step` [N·m] by the kernels of Python, shape (n,).

    The motion begins in `state` and goes through the angles [rad], shape (n,), in steps of dt [s].
    """
    torque = np.empty(len(angle))
    for i, to in enumerate(angle):
        state, torque[i] = model.step(state, to)
    if isinstance(model, Viscoelastic):
        element = np.empty(len(angle))
        viscoelastic_kernels.follow(model.numbers, dt * np.arange(len(angle)), angle, element)
        torque += element + model.damping * np.diff(angle, prepend=angle[:1]) / dt
    return torque


def identifier(name: str) -> str:
    """Returns a name with an underscore for each character that C does not allow in names."""
    found = re.sub(r"[^A-Za-z0-9_]", "_", name)
    if not re.match("[A-Za-z]", found):
        raise InputError(
            f"the name is {shown(name)}: begin the name with a letter from a to z, since the "
            "names of the C functions begin so"
        )
    return found


def comment(paragraphs: Sequence[str]) -> str:
    """Returns a comment in C; a paragraph that begins with spaces keeps its lines."""
    lines = []
    for paragraph in paragraphs:
        kept = paragraph.startswith(" ")
        lines += paragraph.split("\n") if kept else textwrap.wrap(paragraph, WIDTH - 4) or [""]
    safe = (one_line(line.replace("·", " ")).replace("*/", "* /") for line in lines)
    safe = (line.replace("/*", "/ *").encode("ascii", "backslashreplace") for line in safe)
    return "/*" + "\n".join(f" * {line.decode()}".rstrip() for line in safe)[2:] + "\n */"


def parameters(model: HysteresisModel) -> list[str]:
    """Returns lines of the parameters of a model with units; those of an inner model are last."""
    lines = [f"  {model.name}"]
    for name, value in model.to_dict().items():
        if name not in ("model", "hysteresis"):
            unit = model.units.get(name)
            lines += textwrap.wrap(
                f"    {name} = {value}" + (f"  [{unit}]" if unit else ""),
                WIDTH - 4,
                subsequent_indent="      ",
            )
    return lines + (parameters(model.model) if isinstance(model, Wrapper) else [])


def literal(value: float) -> str:
    """Returns a number in C."""
    if not abs(value) <= LARGEST:
        raise InputError(
            f"the model has the number {value:g}, and C code for 32-bit numbers needs at most "
            f"{LARGEST:g}: choose another unit or a smaller number"
        )
    return f"{'-' if math.copysign(1, value) < 0 else ''}AS_({abs(value)!r})"
