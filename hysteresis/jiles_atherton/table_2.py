"""Published parameter sets."""

from .model import JilesAtherton

_TABLE_2 = {
    "shoulder-mpso": (75.0927, 2910.71, 9.455, 8.8561, 652.0938),
    "shoulder-sa-pso": (22.2316, 319.55, 6.3223, 4.7447, 168.582),
    "elbow-mpso": (51.2134, 1213.65, 5.5624, 5.9824, 166.8229),
    "elbow-sa-pso": (11.4488, 128.97, -0.0515, 6.4043, 23.0945),
}

TABLE_2: dict[str, JilesAtherton] = {
    name: JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    for name, (Ms, a, alpha, c, k) in _TABLE_2.items()
}
"""Suit joints as identified by Li et al. 2022, Table 2: by joint and optimizer, in degrees."""
