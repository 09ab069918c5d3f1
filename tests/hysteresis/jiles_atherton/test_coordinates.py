"""The coordinates in which every certified Jiles-Atherton model lies in a box."""

import numpy as np
from activesuit.hysteresis import JilesAtherton
from activesuit.hysteresis.jiles_atherton import coordinates
from activesuit.hysteresis.jiles_atherton.model import PARAMETERS
from helpers import TABLE_2


def test_there_and_back():
    for name in TABLE_2:
        row = np.array(TABLE_2[name])
        point = coordinates.point(row)
        np.testing.assert_allclose(coordinates.rows(point[None])[0], row, rtol=1e-12)


def test_every_steepness_between_the_limits_is_certified():
    rng = np.random.default_rng(0)
    least, most = coordinates.STEEPNESS_LIMITS
    low = np.array([0.0, least + 1e-6, -4.0, 0.0, -1.0])
    high = np.array([8.0, most - 1e-6, 3.0, 9.0, 4.0])
    for row in coordinates.rows(rng.uniform(low, high, (200, 5))):
        model = JilesAtherton(**dict(zip(PARAMETERS, row, strict=True)))
        assert model.certificate().certified
    (row,) = coordinates.rows(np.array([[5.0, most + 1e-3, 1.0, 3.0, 2.0]]))
    model = JilesAtherton(**dict(zip(PARAMETERS, row, strict=True)))
    assert not model.certificate().certified


def test_at_one_shape_the_torque_is_proportional_to_ms():
    shape = np.array([5.0, 0.4, 1.0, 4.0])
    unit = coordinates.unit_rows(shape[None])[0]
    (row,) = coordinates.rows(np.append(shape, np.log(7.0))[None])
    angle = np.array([0.0, 0.6, 0.2, 1.0])
    one, seven = (
        JilesAtherton(**dict(zip(PARAMETERS, r, strict=True)), angle_unit="deg").response(angle)
        for r in (unit, row)
    )
    np.testing.assert_allclose(seven, 7 * one, rtol=1e-6)
