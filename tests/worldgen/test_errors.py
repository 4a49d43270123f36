"""Errors as data: what a program can read from them, and how they read as text."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.errors import (
    FormatError,
    GenerationFailed,
    InvalidParameter,
    InvalidWorld,
    Message,
    NotAGrid,
    OutputError,
    WorldgenError,
)


@pytest.mark.parametrize(
    "kind", [GenerationFailed, InvalidParameter, InvalidWorld, OutputError, WorldgenError]
)
def test_an_error_reads_as_its_problem_and_its_remedy(kind):
    error = kind(
        "too-narrow",
        "door={door:g} m is less than {least:g} m",
        "widen the door",
        door=0.5,
        least=0.75,
    )
    assert str(error) == "door=0.5 m is less than 0.75 m; widen the door"


@pytest.mark.parametrize("kind", [FormatError, NotAGrid])
def test_an_error_in_a_file_reads_as_the_place_and_the_message(kind):
    error = kind(
        "no-magic", "begins with {first!q}", "give a map", line=1, source="a.grid", first=b"\x1bx"
    )
    assert str(error) == r"a.grid:1: begins with '\x1bx'; give a map"


def test_a_message_without_a_remedy_reads_as_its_problem():
    assert (
        str(Message("empty", "there is nothing in {file}", file="a.zip"))
        == "there is nothing in a.zip"
    )


def test_a_list_in_a_message_reads_with_commas():
    assert (
        str(Message("unknown-name", "known: {known!l}", known=["box", "dict"]))
        == "known: box, dict"
    )


def test_an_empty_list_in_a_message_reads_as_its_template_says():
    assert str(Message("unknown-name", "known: {known!l:none}", known=[])) == "known: none"


def test_facts_are_values_that_json_holds():
    facts = Message(
        "x", "words", path=Path("a/b"), number=np.int64(3), both=(np.float64(0.5), Path("c"))
    ).facts
    assert json.loads(json.dumps(facts)) == {"path": "a/b", "number": 3, "both": [0.5, "c"]}


def test_a_message_behind_a_prefix_keeps_its_code_facts_and_remedy():
    inner = Message("below-minimum", "size={size} is below {low}", "give more", size=3, low=10)
    message = inner.behind("{file}: ", file="a.toml")
    assert str(message) == "a.toml: size=3 is below 10; give more"
    assert message.code == "below-minimum"
    assert message.facts == {"size": 3, "low": 10, "file": "a.toml"}


def test_an_error_of_a_message_has_its_code_facts_and_words():
    message = Message("below-minimum", "line={line} is below {low}", "give more", line=3, low=10)
    error = FormatError.of(message, line=7, source="a.map")
    assert (error.code, error.facts, error.line) == ("below-minimum", {"line": 3, "low": 10}, 7)
    assert str(error) == "a.map:7: line=3 is below 10; give more"


def test_an_error_that_went_through_pickle_is_the_same():
    error = FormatError("too-large", "more than {most} bytes", "cut it", source="a.map", most=3)
    copy = pickle.loads(pickle.dumps(error))
    assert (copy.code, copy.facts, str(copy)) == (error.code, error.facts, str(error))


def test_the_helper_for_tests_refuses_another_code():
    with pytest.raises(AssertionError), raises(InvalidParameter, "above-maximum"):
        raise InvalidParameter("below-minimum", "size={size} is below 10", size=3)


def test_the_helper_for_tests_refuses_another_fact():
    with pytest.raises(AssertionError), raises(InvalidParameter, "below-minimum", size=4):
        raise InvalidParameter("below-minimum", "size={size} is below 10", size=3)
