"""Pictures of work envelopes."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.envs.envelope import SUSTAINED, work_envelope
from activesuit.envs.envelope.figures import COLORS, PLANES, envelope_picture, sections_figure
from activesuit.envs.model import ArmConfig
from activesuit.envs.rendering import RenderingUnavailableError

CONFIG = ArmConfig(gravity="microgravity")


@pytest.fixture(scope="module")
def suited():
    return work_envelope(CONFIG, "suited", "loading", spacing=0.04)


def test_sections_show_what_can_be_kept_in_a_plane(suited):
    figure = sections_figure([suited])
    assert [ax.get_title() for ax in figure.axes] == [title for title, *_ in PLANES]
    frontal = figure.axes[2]
    layer = suited.cells[:, 0] == int(0.3 / 0.04)
    across = suited.position[layer & (suited.effort <= SUSTAINED)][:, [1, 2]]
    drawn = np.concatenate([one.vertices for one in frontal.collections[2].get_paths()])
    assert drawn.min(axis=0) == pytest.approx(across.min(axis=0), abs=0.04)
    assert drawn.max(axis=0) == pytest.approx(across.max(axis=0), abs=0.04)
    both = sections_figure([suited, replace(suited, branch="unloading")])
    assert len(both.axes) == 2 * len(PLANES)


def test_the_picture_shows_the_envelope_over_the_arm(suited):
    try:
        with_envelope = envelope_picture([suited], width=160, height=160).astype(int)
    except RenderingUnavailableError:
        pytest.skip("no OpenGL here")
    nothing = replace(suited, effort=np.ones_like(suited.effort))
    arm = envelope_picture([nothing], width=160, height=160).astype(int)
    changed = np.abs(with_envelope - arm).max(axis=-1) > 8
    assert 0.05 < changed.mean() < 0.6
    more = (with_envelope - arm)[changed].mean(axis=0)
    assert COLORS["suited"] == "#0072b2"
    assert more[2] > more[0]  # bluer than before
