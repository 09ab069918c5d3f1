"""Messages are one readable line, whatever they are about."""

import numpy as np
import pytest
from activesuit import checks
from activesuit.assets import Suit, load_suit
from activesuit.errors import LONGEST, InputError, shown, unknown_name
from helpers import assert_refused


class Broken:
    def __repr__(self):
        raise RuntimeError


def test_a_long_message_keeps_its_beginning_and_its_end():
    assert str(InputError("seed is -1: use at least 0")) == "seed is -1: use at least 0"
    assert str(InputError()) == ""
    text = str(InputError(f"suit is {'x' * 3000}: give a name, a path, or 'none'"))
    assert len(text) == LONGEST
    assert text.startswith("suit is xxx")
    assert text.endswith("x: give a name, a path, or 'none'")
    assert " ... " in text


def test_names_in_the_middle_are_left_out_whole():
    names = [f"policy-{i:03}" for i in range(100)]
    text = str(unknown_name("policy", "policy-0500", names))
    assert len(text) <= LONGEST
    begin, end = text.split(": use one of ")[1].split(", ..., ")
    given = f"{begin}, {end}".split(";")[0].split(", ")
    assert set(given) <= set(names)
    assert text.endswith("; did you mean 'policy-050'?")


def test_the_closest_name_may_be_elsewhere():
    places = ["exo.encoder_bits", "exo.encoder_delay", "exo.cuff", "sensing.noise"]
    text = str(unknown_name("field", "encoder_noise", ["noise", "emg_noise"], places))
    assert text.endswith("did you mean 'exo.encoder_bits' or 'exo.encoder_delay' or 'emg_noise'?")
    text = str(unknown_name("field", "nois", ["noise", "emg_noise"], places))
    assert text.endswith("did you mean 'noise'?")


def test_a_message_is_one_line_that_no_terminal_obeys():
    text = str(InputError("curve \x1b[31m\nred\r\x07 \u202e is bad"))
    assert text == r"curve \x1b[31m red\r\x07 \u202e is bad"
    assert text.isprintable()


def test_values_are_shortened_in_the_middle():
    assert shown("elbow") == "'elbow'"
    text = shown(list(range(1000)))
    assert len(text) == 80
    assert text.startswith("[0, 1, 2")
    assert text.endswith("998, 999]")
    nested = []
    for _ in range(100_000):
        nested = [nested]
    assert shown(nested) == "a list"
    assert shown(10**5000) == "a int"
    assert shown(Broken()) == "a Broken"
    assert "\n" not in shown(np.eye(50))


def test_an_object_in_place_of_a_name_is_reported_in_a_line():
    joint = load_suit("mock-suit").joints["elbow_flexion"]
    with pytest.raises(InputError) as error:
        load_suit(joint)
    assert "give it by the name of its joint" in str(error.value)
    with pytest.raises(InputError, match=r"number of episodes is Suit\(.* at least 1$") as error:
        checks.at_least("number of episodes", load_suit("mock-suit"), 1)
    assert len(str(error.value)) <= LONGEST
    text = str(unknown_name("policy", "p" * 1000, ("none", "oracle")))
    assert text.endswith("use one of none, oracle")


def test_what_is_no_count_number_of_workers_or_number():
    cases = {
        r"^trials is .*: use a(t| whole number of at) least 1$": (
            lambda value: checks.at_least("trials", value, 1),
            [True, 1.0, 2.5, "2", None, np.nan, 0, -3],
        ),
        r"^workers is .*: use 1 or more, or -1 for all cores$": (
            checks.workers,
            [0, -7, -2, True, 1.0, "all"],
        ),
        r"^mass is .*: give a .*number \(kg\)$": (
            lambda value: checks.number("mass", value, "kg"),
            [True, 1j, np.complex128(1), "1", None, Suit, 10**400, np.inf],
        ),
    }
    for message, (check, wrong) in cases.items():
        assert_refused(check, [(one, message) for one in wrong])
