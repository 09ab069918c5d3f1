"""The functions of one row are written so that other compilers than numba read them too.

NVIDIA Warp compiles functions of scalars and arrays. It misreads, or reads otherwise than Python:
arguments without a type, whole numbers where floats are meant, tuples as arguments, `for ... else`,
slices, comprehensions, new arrays, and whatever calls Python.
"""

import ast
import inspect

import pytest
from activesuit.envs.model import motor_kernels
from activesuit.envs.person import fatigue_kernels, strength_kernels
from activesuit.envs.simulation import (
    cycle,
    inverse_dynamics,
    measurements,
    sensing,
    settling,
    wearer,
)

ROW_FUNCTIONS = [
    *(cycle.drive, cycle.tire, cycle.strain),
    *(wearer.vary, wearer.most, wearer.describe, wearer.foreseen, wearer.foresee),
    *(wearer.learn, wearer.act),
    *(sensing.touch, sensing.listen),
    *(measurements.is_finite, measurements.measure, inverse_dynamics.arm_torque),
    *(motor_kernels.heated, motor_kernels.clipped),
    *(fatigue_kernels.loaded, fatigue_kernels.tired),
    *(strength_kernels.velocity_factor, strength_kernels.group_torque),
]
LOOPS = [
    cycle.before,
    cycle.after,
    settling.begin,
    settling.imbalance,
    settling.hold,
    sensing.sense,
]
BANNED = (
    *(ast.ListComp, ast.DictComp, ast.SetComp, ast.GeneratorExp, ast.Lambda, ast.List, ast.Dict),
    *(ast.Set, ast.Slice, ast.Starred, ast.With, ast.Try, ast.Raise, ast.While, ast.JoinedStr),
    *(ast.Global, ast.Nonlocal, ast.Yield, ast.Await, ast.ClassDef, ast.Import, ast.ImportFrom),
)


def faults(function):
    """Yields what other compilers would misread in a function, with the number of its line."""
    source = function if isinstance(function, str) else inspect.getsource(function.py_func)
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.FunctionDef)
    for argument in tree.args.args:
        name = getattr(argument.annotation, "id", None)
        if name not in ("int", "float", "bool", "AnyArray"):
            yield f"{tree.name}: argument {argument.arg} has the type {name}"
    for node in (inner for part in tree.body for inner in ast.walk(part)):
        line = getattr(node, "lineno", 0)
        if isinstance(node, BANNED):
            yield f"{tree.name}, line {line}: {type(node).__name__}"
        if isinstance(node, ast.For) and node.orelse:
            yield f"{tree.name}, line {line}: for ... else"
        if isinstance(node, ast.Call):
            yield from calls(tree.name, node)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
            for side in (node.left, node.right):
                if isinstance(side, ast.Constant) and isinstance(side.value, int):
                    yield f"{tree.name}, line {line}: a whole number in a division"


def calls(name, node):
    if node.keywords or any(isinstance(given, ast.Tuple) for given in node.args):
        yield f"{name}, line {node.lineno}: keywords or tuples as arguments"
    if isinstance(node.func, ast.Attribute):
        called = f"{getattr(node.func.value, 'id', '?')}.{node.func.attr}"
        if not (called.startswith("math.") or called == "np.rint"):
            yield f"{name}, line {node.lineno}: calls {called}"


@pytest.mark.parametrize("function", [*ROW_FUNCTIONS, *LOOPS], ids=lambda f: f.__name__)
def test_row_functions_keep_to_the_dialect(function):
    assert list(faults(function)) == []


@pytest.mark.parametrize("module", [cycle, wearer], ids=lambda m: m.__name__)
def test_every_function_of_a_cycle_is_looked_at(module):
    compiled = {value for value in vars(module).values() if hasattr(value, "py_func")}
    assert compiled <= {*ROW_FUNCTIONS, *LOOPS}


WRONG = """
def wrong(row, angle: float) -> None:
    for i in range(3):
        pass
    else:
        angle = 1 / 2 + sum([angle, 1.0]) + np.zeros(3)[0:1] + call((1, 2), by=3)
"""


def test_what_is_misread_is_found():
    found = " ".join(faults(WRONG))
    for fault in (
        *("argument row has the type None", "for ... else", "a whole number in a division"),
        *("List", "calls np.zeros", "Slice", "keywords or tuples as arguments"),
    ):
        assert fault in found
