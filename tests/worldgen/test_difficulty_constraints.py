"""Constraints on metrics: their meaning, and invalid ones."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.difficulty import METRICS, parse
from worldgen.errors import InvalidParameter, WorldgenError

VALUES = {"detour": 3.0, "bottleneck": 0.1, "turns": 4, "length": 6.0}

TRUE = [
    "detour > 2",
    "detour >= 3 and detour <= 3",
    "2 < detour < 4",
    "1 < 2 < detour != 4 > turns - 1",
    "not detour < 2",
    "not (detour < 2 or length > 100)",
    "not not detour == 3",
    "bottleneck < 1.5r",
    "bottleneck==0.1m",
    "length / detour * 2 == 4",
    "-detour < +1 - 2 * (3 - length) / 3",
    "detour > 9 or length > 5 and turns == 4",
    "1e1 > detour",
    "turns // 3 == 1 and turns % 3 == 1",
    ".5 < detour < 5.",
]
FALSE = [
    "detour > 3",
    "2 < detour < 3",
    "bottleneck < 1.2r",
    "detour > 9 and length > 5",
    "concavity < 1",  # which these worlds do not have
    "not concavity < 1",
    "concavity == concavity",
    "detour / 0 > 1",
    "detour // 0 > 1",
    "1 < 2 > 3",
]
WRONG = [
    ("", {"code": "wrong-form", "given": "the end"}, 0),
    ("detour >", {"code": "wrong-form", "given": "the end"}, 8),
    ("detour", {"code": "wrong-form"}, 0),
    ("detour > 3 and length", {"code": "wrong-form"}, 15),
    ("(detour > 3) + 1 > 2", {"code": "wrong-form"}, 0),
    ("detours > 3", {"code": "unknown-name", "name": "detours", "near": "detour"}, 0),
    ("min(detour, 1) > 3", {"code": "unknown-name", "name": "min"}, 0),
    ("detour > 3x", {"code": "unknown-name", "name": "x"}, 10),
    ("detour = 3", {"code": "wrong-form", "given": "'='"}, 7),
    ("(detour > 3", {"code": "wrong-form", "given": "the end"}, 11),
    ("detour > 3 length", {"code": "wrong-form", "given": "'length'"}, 11),
    ("__import__('os')", {"code": "unknown-name", "name": "__import__"}, 0),
    ("detour > 1e999", {"code": "too-large"}, 9),
    ("(" * 60 + "detour" + ")" * 60 + " > 3", {"code": "nested-too-deep", "most": 50}, 51),
    ("-" * 300 + "detour < 0", {"code": "nested-too-deep", "most": 250}, 0),
    ("1" + " + 1" * 300 + " > 0", {"code": "nested-too-deep", "most": 250}, 0),
]


@pytest.mark.parametrize("text", TRUE)
def test_a_constraint_that_holds(text):
    assert parse(text).holds(VALUES, 0.07)


@pytest.mark.parametrize("text", FALSE)
def test_a_constraint_that_does_not_hold(text):
    constraint = parse(text)
    assert not constraint.holds(VALUES, 0.07) and constraint.violation(VALUES, 0.07) > 0


@pytest.mark.parametrize(("text", "expected", "place"), WRONG)
def test_what_is_not_a_constraint_is_refused_with_a_mark_under_it(text, expected, place):
    with raises(InvalidParameter, **expected) as caught:
        parse(text)
    mark = str(caught.value).splitlines()[-1]
    assert mark == "  " + " " * min(place, 60 if place > 60 else place) + "^"


def test_an_unknown_name_comes_with_the_list_of_names():
    with raises(InvalidParameter, "unknown-name", name="hardness") as caught:
        parse("hardness > 1")
    assert caught.value.facts["known"] == list(METRICS)


def test_the_names_asked_for_are_known():
    assert parse("detour > 3 and (length < 2r or not turns > 1)").names == {
        "detour",
        "length",
        "turns",
    }


def test_nearer_worlds_violate_less():
    constraint = parse("detour > 3 and bottleneck < 1.2r")
    far = [
        constraint.violation({"detour": detour, "bottleneck": 0.1}, 0.07)
        for detour in (1.0, 2.0, 2.9, 3.5)
    ]
    assert far == sorted(far, reverse=True) and far[-1] > 0


_parts = st.sampled_from(
    [
        "and",
        "or",
        "not",
        "(",
        ")",
        "<",
        "<=",
        "==",
        "!=",
        ">",
        "+",
        "-",
        "*",
        "/",
        "3",
        "1.5r",
        "2m",
        "detour",
        "solid",
    ]
)


@pytest.mark.gate
@given(
    st.text(max_size=40)
    | st.lists(_parts, max_size=12).map(" ".join)
    | st.lists(_parts, max_size=12).map("".join)
)
def test_any_text_is_a_constraint_or_refused(text):
    try:
        constraint = parse(text)
    except WorldgenError as error:
        assert str(error).endswith("^")
    else:
        assert constraint.violation({"detour": 2.0, "solid": 0.5}, 0.1) >= 0.0


_numbers = st.sampled_from(["1", "2.5", "detour", "length", "(detour + 1)", "-length", "2r"])
_conditions = st.recursive(
    st.builds(
        "{} {} {}".format, _numbers, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), _numbers
    ),
    lambda inner: (
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or"]), inner)
        | st.builds("not ({})".format, inner)
    ),
    max_leaves=6,
)


@pytest.mark.gate
@given(_conditions, st.integers(-3, 3), st.integers(-3, 3))
def test_a_constraint_means_what_python_takes_it_for(text, detour, length):
    constraint = parse(text)
    as_python = eval(text.replace("2r", "0.5"), {"detour": detour, "length": length})
    assert constraint.holds({"detour": detour, "length": length}, 0.25) is as_python
    assert parse(f"not ({text})").holds({"detour": detour, "length": length}, 0.25) is not as_python
    assert math.isfinite(constraint.violation({}, 0.25))
