"""Published numbers and motions that several tests share."""

from itertools import pairwise

import numpy as np

# Table 2 of Li et al. 2022: Ms, a, alpha, c, k with angles in degrees.
TABLE_2 = {
    "shoulder-mpso": (75.0927, 2910.71, 9.455, 8.8561, 652.0938),
    "shoulder-sa-pso": (22.2316, 319.55, 6.3223, 4.7447, 168.582),
    "elbow-mpso": (51.2134, 1213.65, 5.5624, 5.9824, 166.8229),
    "elbow-sa-pso": (11.4488, 128.97, -0.0515, 6.4043, 23.0945),
}


def sweep(*turns: float, samples: int = 200) -> np.ndarray:
    """Angles that run through `turns` [rad], `samples` per branch."""
    branches = [np.linspace(start, end, samples)[1:] for start, end in pairwise(turns)]
    return np.concatenate([[turns[0]], *branches])
