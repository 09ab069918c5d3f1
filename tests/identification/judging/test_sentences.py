"""Every sentence by its kind, with the numbers that the judgements give."""

from string import Formatter

import pytest
from activesuit.identification.judging.sentences import OPTIONS, SENTENCES, Remark


def filled(kind):
    """Returns the sentence of a kind whose words are x and whose numbers are 3."""
    fields = {name: spec for _, name, spec, _ in Formatter().parse(SENTENCES[kind]) if name}
    return Remark(kind, {name: 3 if fields[name] else "x" for name in fields})


@pytest.mark.parametrize("kind", SENTENCES)
def test_every_sentence_can_be_said(kind):
    said = filled(kind).sentence
    assert "{" not in said and not said.endswith(".")
    assert said[0] == said[0].lower() or said.startswith("NRMSE")


def test_options_belong_to_sentences_and_are_written_for_python_and_the_command_line():
    assert OPTIONS.keys() <= SENTENCES.keys()
    for kind, python, command in [
        ("tare", "(corrections=Corrections(tare='fit'))", "(--tare fit)"),
        ("outliers", "(method=Search(..., objective='robust'))", "(--objective robust)"),
        ("misfit", "(select(curves))", "(--method auto)"),
        ("start", "(initial_torque='identified')", "(--initial-torque identified)"),
        ("range", "show more", "show more"),
        ("wandering", "both records together", "FIRST.csv SECOND.csv --method auto)"),
    ]:
        assert str(filled(kind)).endswith(python)
        assert filled(kind).advice.endswith(command)


def test_a_remark_is_data_with_a_code():
    remark = Remark("unit angle", {"span": 0.01711})
    assert (remark.code, remark.option) == ("unit", None)
    sentence = "the angles span only 0.0171 rad: check their unit"
    assert remark.to_dict() == {"code": "unit", "sentence": sentence, "option": None}
