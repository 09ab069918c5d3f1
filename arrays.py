"""The array type of the whole package."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A NumPy array of float64; its docstring gives its shape and unit."""
