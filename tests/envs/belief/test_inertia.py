"""The inertia that policies believe in, against MuJoCo and the conservation of energy."""

import mujoco
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.belief.trigonometric import Trigonometric
from activesuit.envs.plant import Plant

POSES = np.random.default_rng(0).uniform(-1, 2, (6, 4))
RATES = np.random.default_rng(1).normal(size=(6, 4))


@pytest.fixture(scope="module")
def arm():
    return Plant.of(ArmEnv().episodes).believed()


def test_it_is_the_mass_matrix_of_the_model(arm):
    model = arm.model()
    data, full = mujoco.MjData(model), np.empty((4, 4))
    for pose, found in zip(POSES, arm.inertia()(POSES), strict=True):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_fullM(model, data, full)
        np.testing.assert_allclose(found, full, atol=1e-12)


def test_motion_changes_momentum_by_the_slope_of_the_energy(arm):
    inertia, step = arm.inertia(), 1e-5
    _, gyration = inertia.momentum(POSES, RATES)
    for place, joint in enumerate((1, 2)):
        away = step * np.eye(4)[joint]
        more, less = (
            np.einsum("ni,nij,nj->n", RATES, inertia(POSES + way * away), RATES) / 2
            for way in (1, -1)
        )
        np.testing.assert_allclose(gyration[:, place], (more - less) / (2 * step), atol=1e-8)


def test_what_is_carried_and_cuffs(arm):
    whole, carried = arm.inertia(), arm.carried_inertia()
    exo = arm.exo_inertia()
    assert (0 < exo.nominal()).all()
    assert (exo.nominal() < carried.nominal()).all()
    assert (carried.nominal() < whole.nominal()).all()
    cuffs = Plant.of(ArmEnv(coupling="cuffs").episodes).believed()
    np.testing.assert_allclose(cuffs.inertia()(POSES), whole(POSES), atol=1e-9)


def test_rows_are_alike(arm):
    inertia = arm.inertia()
    together = inertia.momentum(POSES, RATES)
    for row in range(len(POSES)):
        alone = inertia.momentum(POSES[[row]], RATES[[row]])
        for one, many in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one[0], many[row])


def test_polynomials_of_sines_are_found_without_error():
    def function(angle):
        return np.array([np.sin(angle[0]) ** 2 * np.cos(angle[1]), 3 + np.sin(2 * angle[1])])

    def slope(angle):
        return np.array([np.sin(2 * angle[0]) * np.cos(angle[1]), 0.0])

    found, angle = Trigonometric(function, 2, 2), POSES[:, :2]
    np.testing.assert_allclose(found(angle), [function(one) for one in angle], atol=1e-14)
    np.testing.assert_allclose(found(angle, slope=0), [slope(one) for one in angle], atol=1e-14)
