"""The array type of the whole package."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""NumPy array of float64; the docstring of each function gives its shape and its unit."""

AnyArray = NDArray[Any]
"""An array of numbers of any type, as kernels take it."""
