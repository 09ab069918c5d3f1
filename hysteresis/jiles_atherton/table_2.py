"""Published parameter sets of suit joints, as models."""

from ...published import LI_TABLE_2
from .model import JilesAtherton

TABLE_2: dict[str, JilesAtherton] = {
    name: JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    for name, (Ms, a, alpha, c, k) in LI_TABLE_2.items()
}
"""Suit joints as identified by Li et al. 2022, Table 2: by joint and optimizer, in degrees."""
