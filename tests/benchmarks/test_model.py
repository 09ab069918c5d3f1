"""The model's benchmark: steps converge, and a suit costs what a suit may cost."""

import json
from dataclasses import replace

import pytest
from activesuit.benchmarks import effort, model
from activesuit.benchmarks.__main__ import main
from helpers import set_all

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def result():
    from contextlib import redirect_stdout
    from io import StringIO

    with redirect_stdout(StringIO()) as text, pytest.MonkeyPatch.context() as patch:
        short = replace(model.ARM_TRACKING, duration=1.0)
        set_all(patch, model, ARM_TRACKING=short, STEPS=100)
        set_all(patch, effort, EPISODES=2, suit_names=lambda: ["mock-suit", "emu-like"])
        main(["model", "--repeats", "1", "--json"])
    return json.loads(text.getvalue())


def test_each_coupling_is_timed(result):
    assert len(result["rows"]) == 3
    assert all(row["ratio"] > 0 for row in result["rows"])


@pytest.mark.parametrize("coupling", ["rigid", "cuffs"])
@pytest.mark.parametrize("quantity", ["human", "suit", "angle"])
def test_physics_steps_converge_to_first_order(result, coupling, quantity):
    found = [error for error in result["step_errors"] if error["coupling"] == coupling]
    errors = {error["time_step"]: error[quantity] for error in found}
    assert errors[0.002] / errors[0.001] == pytest.approx(2, rel=0.2)
    # The differences are from 0.125 ms: of 0.5 ms three units of it, of 0.25 ms one.
    assert errors[0.0005] / errors[0.00025] == pytest.approx(3, rel=0.2)


def test_default_steps_cost_less_than_half_a_percent_of_the_wearers_torque(result):
    defaults = {("rigid", 0.002), ("cuffs", 0.001)}
    found = [e for e in result["step_errors"] if (e["coupling"], e["time_step"]) in defaults]
    assert len(found) == 2
    assert all(error["human"] < 0.005 * 26 for error in found)  # N·m, docs/model.md


def test_an_emu_costs_more_work_than_the_mock_suit(result):
    costs = [one for one in result["suit_costs"] if one["joint"] == "shoulder_flexion"]
    mock, emu = ([c["work"] for c in costs if c["suit"] == s] for s in ("mock-suit", "emu-like"))
    assert all(1 < less < more for less, more in zip(mock, emu, strict=True))
