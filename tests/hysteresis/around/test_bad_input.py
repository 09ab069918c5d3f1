"""What models around models refuse: numbers, times, and an order in which they cannot be."""

import numpy as np
from activesuit.hysteresis import Asymmetric, Backlash, Clipped, Viscoelastic, model_from_dict
from helpers import assert_refused


def test_wrong_numbers_are_refused(elbow):
    ranges, gaps = ((1, 0), (0, np.inf), (0, np.nan), 3, (0.5, 0.5)), (0.0, -0.1, np.inf, "x")
    rows = [(Clipped, {"angle_range": one}, "angle_range is") for one in ranges]
    rows += [(Backlash, {"gap": one}, "gap is") for one in gaps]
    rows += [
        (Viscoelastic, {"damping": -0.1}, "damping is -0.1 N.m.s/rad: give at least 0"),
        (Viscoelastic, {"relaxation_stiffness": 1.0}, "relaxation_time is 0 s"),
        (Viscoelastic, {"relaxation_time": np.nan}, "relaxation_time"),
    ]
    assert_refused(lambda around, change: around(model=elbow, **change), rows)
    timed = Viscoelastic(model=elbow, damping=0.1).response
    wrong = [(0.0, "give as many"), (1.0, 0.0, r"time\[1\] is 0 s after 1 s")]
    assert_refused(lambda *time: timed([0.5, 0.6], time=time), wrong)


def test_wrong_orders_are_refused(elbow):
    bent = Asymmetric(model=elbow, polynomial=[0.1])
    play, rate = Backlash(model=elbow, gap=0.1), Viscoelastic(model=elbow, damping=0.1)
    kept = Clipped(model=elbow, angle_range=(0, 1))
    table = [
        (Viscoelastic, {}, (rate,), "not viscoelastic itself"),
        (Backlash, {"gap": 0.1}, (play, rate, "x"), "bare, `Clipped` or `Asymmetric`; put a dash"),
        (Asymmetric, {"polynomial": [0.1]}, (play, bent), "hysteresis model, bare or `Clipped`"),
        (Clipped, {"angle_range": (0, 1)}, (play, bent, kept, "x"), "one hysteresis model without"),
    ]
    rows = [(make, given, one, words) for make, given, inside, words in table for one in inside]
    assert_refused(lambda make, given, one: make(model=one, **given), rows)
    content = {"model": "viscoelastic", "damping": 0.1}
    words = "'viscoelastic' has no 'hysteresis': give the model"
    assert_refused(model_from_dict, [(content, words)])
