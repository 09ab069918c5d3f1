"""The inertia that policies believe in, against MuJoCo and the conservation of energy."""

import mujoco
import numpy as np
import pytest
from activesuit.envs import ArmEnv
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
