"""C code of policies: the same torques as in Python, also where the C code is in the loop."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from activesuit.assets import Suit, SuitJoint, load_suit
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.c_export import exportable, policy_header
from activesuit.envs.vector_env import ArmVectorEnv
from activesuit.hysteresis import Backlash, JilesAtherton, Viscoelastic
from activesuit.scripts.main import main
from c_programs import answers, compiled
from helpers import assert_refused

DEVICE = Path(__file__).parents[3] / "docs" / "device"
PROGRAM = """#include <stdio.h>
#include "policy.h"
int main(void)
{
    double seen[8];
    policy_state state;
    policy_real angle[4], rate[4], torque[2];
    for (long i = 0; fread(seen, sizeof seen, 1, stdin) == 1; i++) {
        for (int j = 0; j < 4; j++) {
            angle[j] = (policy_real)seen[j];
            rate[j] = (policy_real)seen[4 + j];
        }
        if (i == 0)
            policy_init(&state, angle);
        policy_step(&state, angle, rate, torque);
        for (int j = 0; j < 2; j++) {
            double out = (double)torque[j];
            fwrite(&out, sizeof out, 1, stdout);
        }
    }
    double size = sizeof state / sizeof(policy_real);
    fwrite(&size, sizeof size, 1, stdout);
    return 0;
}
"""


def rich_suit():
    """A suit whose elbow has play, a dashpot and a Maxwell element."""
    joints = dict(load_suit("mock-suit").joints)
    elbow = joints["elbow_flexion"]
    slow = {"damping": 0.3, "relaxation_stiffness": 2.0, "relaxation_time": 0.1}
    model = Viscoelastic(model=Backlash(model=elbow.model, gap=0.04), **slow)
    joints["elbow_flexion"] = elbow.model_copy(update={"model": model})
    return Suit(name="rich", description="For a test.", joints=joints)


def observations(samples=2000):
    """Angles and rates of a random motion with stops, as encoders measure them."""
    rng = np.random.default_rng(5)
    rate = np.repeat(rng.normal(0, 1.0, (samples // 20, 4)), 20, axis=0)
    rate[rng.random(samples) < 0.2] = 0
    angle = np.array([0.1, 0.6, 1.0, 0.0]) + np.cumsum(0.01 * rate, axis=0)
    count = 2 * np.pi / 2**14
    angle = count * np.rint((0.6 * np.sin(angle) + 0.6) / count)
    return np.float32(angle).astype(float), np.float32(rate).astype(float)


CASES = {
    **{name: (name, {}) for name in ("transparent", "gravity", "feedforward", "complement")},
    "compensation": ("compensation:lead=0.03,friction=0.5,wearer.mass=65", {}),
    "compensation, gain": ("compensation:gain=1.7", {"suit": rich_suit()}),
    "compensation, moon, load": ("compensation", {"gravity": "moon", "payload": {"mass": 3.0}}),
    "compensation, cuffs": ("compensation", {"coupling": "cuffs", "side": "left", "suit": "none"}),
    "compensation, play and damping": ("compensation", {"suit": rich_suit()}),
}


def test_every_policy_that_can_be_exported_is_compared():
    assert {name.partition(",")[0] for name in CASES} == set(exportable())


@pytest.mark.parametrize("name", CASES)
def test_c_computes_what_the_policy_computes(name, tmp_path):
    spec, options = CASES[name]
    policy = make_policy(spec, ArmVectorEnv(1, **{"gravity": "earth", **options}))
    text, (part,) = policy_header(spec, policy, "policy")
    (tmp_path / "policy.h").write_text(text, encoding="ascii")
    angle, rate = observations()
    expected = np.empty((len(angle), 2))
    for i in range(len(angle)):
        seen = {"angle": angle[i : i + 1], "rate": rate[i : i + 1]}
        if i == 0:
            policy.begin(seen)
        expected[i] = np.clip(policy.torque(seen), -policy.peak, policy.peak)[0]
    peak = np.abs(expected).max()
    for kind, tolerance in (("double", 1e-12), ("float", 5e-5)):
        program = compiled(tmp_path, PROGRAM, kind)
        *torque, size = answers(program, np.hstack([angle, rate]))
        torque = np.reshape(torque, (-1, 2))
        np.testing.assert_allclose(torque, expected, rtol=0, atol=tolerance * peak)
        assert size == part.state


@pytest.mark.parametrize(("at", "bad"), [(0, np.nan), (20, np.inf)])
def test_an_angle_that_is_not_finite_is_forgotten(tmp_path, at, bad):
    spec = "compensation"
    policy = make_policy(spec, ArmVectorEnv(1, gravity="earth", suit=rich_suit()))
    (tmp_path / "policy.h").write_text(policy_header(spec, policy, "policy")[0])
    angle, rate = observations(400)
    rate[:] = 0
    angle[at - 1 if at else 0 :] = angle[at]  # the arm rests, so that one reading is no motion
    program = compiled(tmp_path, PROGRAM)
    expected = np.reshape(answers(program, np.hstack([angle, rate]))[:-1], (-1, 2))
    angle[at, 2] = bad  # gives no torque, and leaves nothing behind
    torque = np.reshape(answers(program, np.hstack([angle, rate]))[:-1], (-1, 2))
    assert (torque[at] == 0).all() and (expected[at + 1 :] != 0).all()
    np.testing.assert_allclose(torque[at + 2 :], expected[at + 2 :], rtol=0, atol=1e-12)


def test_a_policy_that_cannot_be_exported():
    arms = ArmVectorEnv(1, sensors=["encoders", "interaction"])
    message = "cannot be exported as C code: use one of transp"
    specs = ("adaptive", "none", "compensation:guard=true")
    assert_refused(
        lambda spec: policy_header(spec, make_policy(spec, arms), "policy"),
        [(spec, message) for spec in specs],
    )
    # Nor can one whose suit has no certificate.
    model = JilesAtherton(Ms=22, a=319, alpha=6.3, c=4.7, k=168, angle_unit="deg")
    about = {"range": (0, 1), "start_angle": 0.0, "grade": "assumed", "source": "a test"}
    suit = {"elbow_flexion": SuitJoint.from_model(model, **about)}
    policy = make_policy({"name": "feedforward", "suit": suit}, ArmVectorEnv(1))
    assert_refused(policy_header, [("feedforward", policy, "policy", "certificate margin is -")])


@pytest.mark.slow
def test_the_c_code_in_the_loop_relieves_as_the_policy_does(tmp_path, monkeypatch):
    for name in ("control.c", "loop.py"):
        shutil.copy(DEVICE / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "loop", raising=False)
    main(["export", "compensation", "--c", "--out", "compensation.h"])
    compiled(tmp_path, (tmp_path / "control.c").read_text(), "float", "control").rename("control")
    options = {"motions": 8, "gravity": "earth", "max_episode_steps": 150, "apart": False}
    names = ["compensation", "loop:OnDevice"]
    found = evaluate("ActiveSuit/ElbowFlexion-v0", names, **options)
    policy, device = (found.relief(name).value for name in names)
    assert device == pytest.approx(policy, rel=0.01)
    effort = {name: np.mean(score.effort) for name, score in found.scores.items()}
    assert effort["loop:OnDevice"] == pytest.approx(effort["compensation"], rel=0.01)
    assert effort["suited"] > 1.5 * effort["compensation"]
