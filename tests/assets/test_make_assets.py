"""The shipped curves and suits are what the committed script makes."""

import numpy as np
from activesuit.assets import CURVES, FOLDER, load_suit
from activesuit.envs.composition import joint_models
from activesuit.scripts import make_assets


def test_shipped_files_are_reproduced(tmp_path):
    make_assets.main(tmp_path)
    for name in CURVES:
        path = f"curves/{name}.csv"
        assert (tmp_path / path).read_text() == (FOLDER / path).read_text()
    angle = np.concatenate([np.linspace(0.6, 1.2, 50), np.linspace(1.2, 0.6, 50)])
    for name in ("mock-suit", "published-2022"):
        shipped = load_suit(name)
        made = load_suit(tmp_path / "suits" / f"{name}.json")
        assert made.description == shipped.description
        for joint, model in joint_models(shipped).items():
            # Least squares may end a hair elsewhere with another BLAS.
            again = joint_models(made)[joint]
            np.testing.assert_allclose(
                again.response(angle), model.response(angle), atol=1e-3, err_msg=joint
            )


def test_the_curves_say_what_they_are():
    for name in CURVES:
        text = (FOLDER / "curves" / f"{name}.csv").read_text()
        assert "SYNTHETIC" in text
        assert "make_assets" in text
