"""Flags: each is a field of the environment, by its name; a wrong one is answered at once."""

from dataclasses import fields, is_dataclass

import pytest
from activesuit.envs import ArmConfig
from activesuit.envs.domain.randomization import Randomization
from activesuit.errors import InputError
from activesuit.scripts.names import STANDS_FOR, check_names, option_names
from activesuit.scripts.options import flags, parsed
from helpers import python

COMMANDS = {"options": "simulate", "environment": "benchmark", "arm": "export"}


def names(found, prefix=""):
    for name, default in found:
        if is_dataclass(default):
            inner = ((one.name, one.default) for one in fields(default))
            yield from names(inner, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}".replace("_", "-")


@pytest.mark.parametrize("kind", STANDS_FOR)
def test_names_that_are_read_are_those_that_there_are(kind):
    made = {*names((name, default) for name, (_, default) in flags(kind).items())}
    read = option_names(COMMANDS[kind])
    assert made < read
    assert "payload" in read - made
    assert not {one for one in read - made if "." in one}


def test_flags_become_options_by_their_names_in_python():
    given = {}

    def command(policy: str = "none", **options):
        given.update(options, policy=policy)

    line = "--payload 3 --fatigue false --wearer.sex female --tilt 0.1 0 --exo.elbow.mass=1"
    line += " --preconditioned --faults.stuck elbow_flexion --belief.suit emu-like --policy gravity"
    parsed(command, "activesuit x", line.split())()
    assert given == {
        **{"payload": {"mass": 3.0}, "fatigue": False, "wearer": {"sex": "female"}},
        **{"tilt": (0.1, 0.0), "exo": {"elbow": {"mass": 1.0}}, "preconditioned": True},
        **{"faults": {"stuck": ("elbow_flexion",)}, "belief": {"suit": "emu-like"}},
        "policy": "gravity",
    }


WRONG = {
    "simulate --taks X": "unknown option --taks: did you mean --task?",
    "evaluate --rate-cutof=3": "unknown option --rate-cutof: did you mean --sensing.rate-cutoff?",
    "rig --zzz": "unknown option --zzz: activesuit rig --help lists all",
    "list suits --flie": "unknown option --flie",
    "demo --suit x": "unknown option --suit",
}


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_name_is_answered_without_anything_slow(line):
    code = (
        "import sys; from activesuit.scripts.main import main\n"
        "try: main(sys.argv[1:])\n"
        "finally: print({'numba', 'mujoco', 'scipy', 'tyro'} & {*sys.modules})"
    )
    ended = python("-c", code, *line.split())
    assert ended.stdout == "set()\n"
    assert WRONG[line] in ended.stderr


def test_right_names_pass():
    check_names("identify", ["--rate", "viscous", "--for", "any", "--out=x", "a.csv"])
    check_names("list tasks", ["--json"])


def test_weightless_is_microgravity():
    for make in (lambda one: ArmConfig(gravity=one), lambda one: Randomization(gravity=(one,))):
        with pytest.raises(InputError, match=r"'weightless' .* write 'microgravity' instead"):
            make("weightless")
