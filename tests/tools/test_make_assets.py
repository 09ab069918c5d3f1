"""The shipped curves and suits are what the committed script makes."""

import numpy as np
from activesuit.assets import FOLDER, load_suit, suit_names
from activesuit.tools import make_assets


def test_shipped_files_are_reproduced(tmp_path):
    make_assets.main(tmp_path)
    for path in sorted((FOLDER / "curves").glob("*.csv")):
        assert (tmp_path / "curves" / path.name).read_text() == path.read_text()
    angle = np.concatenate([np.linspace(0.6, 1.2, 50), np.linspace(1.2, 0.6, 50)])
    assert {path.stem for path in (tmp_path / "suits").iterdir()} == set(suit_names())
    for name in suit_names():
        shipped = load_suit(name)
        made = load_suit(tmp_path / "suits" / f"{name}.json")
        for field in ("name", "description", "label", "pressure_kpa"):
            assert getattr(made, field) == getattr(shipped, field)
        for joint, entry in shipped.joints.items():
            # Least squares may end a hair elsewhere with another BLAS.
            again = made.joints[joint].model.response(angle)
            np.testing.assert_allclose(again, entry.model.response(angle), atol=1e-3, err_msg=joint)


def test_the_curves_say_what_they_are():
    for path in (FOLDER / "curves").glob("*.csv"):
        text = path.read_text()
        assert "SYNTHETIC" in text
        assert "make_assets" in text
