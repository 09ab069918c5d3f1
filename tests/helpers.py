"""Published numbers and motions that several tests share."""

from itertools import pairwise

import numpy as np
from activesuit.published import LI_TABLE_2 as TABLE_2  # noqa: F401  (for the tests)


def sweep(*turns: float, samples: int = 200) -> np.ndarray:
    """Angles that run through `turns` [rad], `samples` per branch."""
    branches = [np.linspace(start, end, samples)[1:] for start, end in pairwise(turns)]
    return np.concatenate([[turns[0]], *branches])
