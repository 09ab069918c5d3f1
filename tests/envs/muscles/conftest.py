"""Tests of muscles run where the extra `muscles` is installed."""

import pytest

pytest.importorskip("myo_sim")
