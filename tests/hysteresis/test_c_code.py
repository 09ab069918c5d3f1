"""The C code of every model, compiled and compared with the kernels of Python."""

import subprocess

import numpy as np
import pytest
from activesuit.benchmarks.device import DT, motion, run_in_c
from activesuit.benchmarks.references import EXAMPLES, Example
from activesuit.errors import InputError
from activesuit.hysteresis import (
    TABLE_2,
    Asymmetric,
    Backlash,
    BoucWen,
    Clipped,
    JilesAtherton,
    Viscoelastic,
)
from activesuit.hysteresis.around import Wrapper
from activesuit.hysteresis.c_code import Header, comment, identifier, parameters, stepped
from c_programs import answers, compiled, need_compiler
from maxwell_slip import MaxwellSlip

TOLERANCE = {"double": 1e-12, "float": 5e-5}  # largest difference from Python over the peak
POLYNOMIAL = (0.3, -0.5, 0.8)


def start_of(case):
    """Angle and torque at which the bare model inside begins at its lowest angle."""
    angle, torque, model = case.low, case.start_torque, case.model
    if isinstance(model, Viscoelastic):
        model = model.model
    gap = model.gap if isinstance(model, Backlash) else 0.0
    model = model.model if gap else model
    if isinstance(model, Asymmetric):
        torque += float(model.elastic(angle))
    return angle + np.copysign(gap / 2, torque) * (abs(torque) > 1e-9), torque


def around(model, low, high):
    """Every way in which other models can be around one."""
    clipped = Clipped(model=model, angle_range=(low, low + 0.8 * (high - low)))
    bent = Asymmetric(model=clipped, polynomial=POLYNOMIAL)
    play = Backlash(model=bent, gap=0.05)
    rate = {"damping": 0.2, "relaxation_stiffness": 3.0, "relaxation_time": 0.15}
    return {
        "clipped": clipped,
        "asymmetric": Asymmetric(model=model, polynomial=POLYNOMIAL),
        "asymmetric clipped": bent,
        "backlash": Backlash(model=model, gap=0.05),
        "backlash clipped": Backlash(model=clipped, gap=0.05),
        "backlash asymmetric clipped": play,
        "viscoelastic": Viscoelastic(model=model, **rate),
        "viscoelastic backlash asymmetric clipped": Viscoelastic(model=play, **rate),
        "dashpot clipped": Viscoelastic(model=clipped, damping=0.4),
    }


def cases():
    found = [one for examples in EXAMPLES.values() for one in examples]

    def add(name, model, low, high, torque=0.0):
        found.append(Example(name=name, model=model, low=low, high=high, start_torque=torque))

    for name, (one, *_) in EXAMPLES.items():
        if not isinstance(one.model, Wrapper):
            for kind, model in around(one.model, one.low, one.high).items():
                add(f"{kind} {name}", model, one.low, one.high, one.start_torque)
    numbers = {"Ms": 12, "a": 40, "alpha": 1.0, "c": 0.2, "k": 20, "angle_unit": "deg"}
    add("J-A that drives", JilesAtherton(**numbers, allow_active=True), -2, 2)
    stiff = {"elastic": 2, "hysteretic": 5}
    for n, beta, gamma in ((3.5, 4, -3), (1, 3, -5), (20, 1, 0), (2, 2, -2), (1.2, 1, 1)):
        model = BoucWen(**stiff, beta=beta, gamma=gamma, n=n, rest_angle=0.1)
        add(f"bouc-wen {n} {beta} {gamma}", model, -1, 1)
    add("bouc-wen from far", BoucWen(**stiff, beta=3, gamma=1, n=4), 0, 1, 1e6)
    return {one.name: one for one in found}


CASES = cases()


def spiral(low, high):
    """More nested turns than a Preisach model remembers, inwards and outwards again."""
    way = (high - low) / 2 * 0.97 ** np.arange(120) * (-1.0) ** np.arange(120)
    return (low + high) / 2 + np.concatenate([way, way[::-1]])


def test_every_model_and_every_class_around_is_compared():
    used = {type(case.model) for case in CASES.values()}
    assert used == {type(one.model) for examples in EXAMPLES.values() for one in examples}
    assert all(case.model.c_source.is_file() for case in CASES.values())


def apart(names):
    """The cases, and kinds of numbers, whose C code computes something else than Python."""
    need_compiler()
    given, expected = {}, {}
    for number, name in enumerate(names):
        case = CASES[name]
        angle, torque = start_of(case)
        angles = motion(case.low, case.high, number)
        angles[-240:] = spiral(case.low, case.high)
        given[name] = (case.model, case.model.start(angle, torque), angles)
        expected[name] = stepped(case.model, case.model.start(angle, torque), angles, DT)
    found = run_in_c(given)
    for kind, allowed in TOLERANCE.items():
        for name, (model, start, _) in given.items():
            one = found[kind][name]
            difference = np.abs(one.torque - expected[name]).max() / np.abs(expected[name]).max()
            same_state = one.state == Header("x").model("as_joint", model, start)
            if not (difference <= allowed and same_state):
                yield name, kind, difference, same_state


def test_c_computes_what_python_computes():
    bare = [examples[0].name for examples in EXAMPLES.values()]
    assert not [*apart([*bare, "viscoelastic backlash asymmetric clipped dahl"])]


@pytest.mark.slow
def test_c_computes_what_python_computes_in_every_form_and_around_every_model():
    assert not [*apart(CASES)]


def test_two_headers_in_one_file(tmp_path):
    model = TABLE_2["elbow-sa-pso"]
    for prefix, angle in (("one", 0.5), ("two", 0.6)):
        header = Header(prefix)
        header.model("as_elbow", model, model.start(angle))
        (tmp_path / f"{prefix}.h").write_text(header.text([prefix]))
    program = """#include <stdio.h>
#include "one.h"
#include "two.h"
#include "one.h"
int main(void)
{
    one_elbow_state a; two_elbow_state b;
    one_elbow_init(&a); two_elbow_init(&b);
    double torque[2] = {one_elbow_step(&a, 1), two_elbow_step(&b, 1)};
    return fwrite(torque, sizeof torque, 1, stdout) != 1;
}
"""
    found = answers(compiled(tmp_path, program))
    expected = [model.step(model.start(angle), 1.0)[1] for angle in (0.5, 0.6)]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_an_angle_that_is_not_finite_changes_nothing(tmp_path):
    names = ["clipped jiles-atherton", "viscoelastic backlash asymmetric clipped preisach"]
    names += [name for name, examples in EXAMPLES.items() for name in [examples[0].name]]
    header, runs, at = Header("all"), [], "(all_real)0.8"
    for number, name in enumerate(names):
        case = CASES[name]
        header.model(f"as_m{number}", case.model, case.model.start(*start_of(case)))
        dt = ", 1" if isinstance(case.model, Viscoelastic) else ""
        step = f"all_m{number}_step(&s, %s{dt})"
        again = f"!isfinite({step % at})" if dt else f"torque != {step % at}"
        runs.append(
            f"""{{ all_m{number}_state s; all_m{number}_init(&s);
            const all_real torque = {step % at};
            failed |= !isfinite(torque) || !isnan({step % "(all_real)NAN"}) || {again}; }}"""
        )
    (tmp_path / "all.h").write_text(header.text(["All."]))
    runs = "\n".join(runs)
    program = f'#include "all.h"\nint main(void) {{ int failed = 0; {runs} return failed; }}\n'
    for kind in TOLERANCE:
        assert subprocess.run([compiled(tmp_path, program, kind)], check=False).returncode == 0


def test_a_model_without_c_code_is_refused():
    model = MaxwellSlip(elastic=2.0, spring=20.0, limit=3.0)
    for one in (model, Clipped(model=model, angle_range=(0, 1))):
        with pytest.raises(InputError, match=r"has no C code: write maxwell_slip\.c beside"):
            Header("x").model("as_joint", one, model.start(0.5))
    form = JilesAtherton(Ms=1, a=1, alpha=0, c=0.5, k=1, form="original", allow_active=True)
    with pytest.raises(InputError, match="'jiles-atherton' has no C code"):
        Header("x").model("as_joint", form, form.start(0.0))


def test_a_number_that_32_bits_cannot_hold_is_refused():
    model = BoucWen(elastic=1e39, hysteretic=1, beta=1, gamma=0, n=1)
    with pytest.raises(InputError, match=r"has the number 1e\+39, and C code for 32-bit"):
        Header("x").model("as_joint", model, model.start(0.0))


def test_names():
    assert identifier("my-suit 2.v") == "my_suit_2_v"
    for name in ("2nd", "_x", "", "été"):
        with pytest.raises(InputError, match="begin the name with a letter from a to z"):
            identifier(name)


def test_comments_end_where_they_should(tmp_path):
    text = comment(["ends */ int x = y; /* begins ??/ and \x1b bell \\", " kept: N·m θ\n  here *"])
    assert text.isascii()
    assert text.count("*/") == text.count("/*") == 1
    compiled(tmp_path, text + "\nint main(void) { return 0; }\n")


def test_parameters_are_listed_with_their_units():
    lines = parameters(CASES["backlash asymmetric clipped dahl"].model)
    assert "    gap = 0.05  [rad]" in lines
    assert "    stiffness = 9.0  [N·m/rad]" in lines
    names = [line.strip() for line in lines if line[2] != " "]
    assert names == ["backlash", "asymmetric", "clipped", "dahl"]
