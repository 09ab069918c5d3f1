"""Kernel of the wearer's torque, element by element."""

# pyright: reportCallIssue=false, reportFunctionMemberAccess=false

from numba import vectorize


@vectorize("f8(f8, f8, f8, f8, f8, f8)", cache=True)
def _pull(intrinsic, foreseen, feedback, past, low, high):
    """Returns the sum of intrinsic, foreseen and feedback torque, within strength."""
    return max(low, min(intrinsic + foreseen + feedback * past, high))


# Called through NumPy: the call of numba's own object takes longer than the work.
pull = _pull.ufunc
