"""Kernels of the wearer's torque: scalar functions, and the same for arrays element by element."""

# pyright: reportCallIssue=false, reportFunctionMemberAccess=false

from numba import njit, vectorize


@njit(cache=True)
def pulled(
    intrinsic: float, foreseen: float, feedback: float, past: float, low: float, high: float
) -> float:
    """Returns the sum of intrinsic, foreseen and feedback torque, within strength."""
    return max(low, min(intrinsic + foreseen + feedback * past, high))


# Called through NumPy: the call of numba's own object takes longer than the work.
pull = vectorize("f8(f8, f8, f8, f8, f8, f8)", cache=True)(pulled.py_func).ufunc
