"""The numbers in constraints: their values, and errors with a mark under the place."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.difficulty import parse
from worldgen.errors import InvalidParameter

VALUES = {"turns": 7, "detour": 5}
RADIUS = 1000.0


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("turns // 2 - 3", 0),
        (" -turns % 4", 1),
        ("detour + 1", 6),
        ("2 * ((turns + detour) - 1)", 22),
        ("1.5r / 2", 750.0),
        ("turns * 9007199254740993 % 2", 1),  # whole numbers stay whole
    ],
)
def test_a_number_s_value(text, value):
    assert parse(f"{text} == {value}").holds(VALUES, RADIUS)
    assert not parse(f"{text} == {value} + 1").holds(VALUES, RADIUS)


@pytest.mark.parametrize(
    ("text", "expected", "place"),
    [
        ("()", {"code": "wrong-form", "given": "')'"}, 1),
        ("(1", {"code": "wrong-form", "given": "the end"}, 2),
        ("(1, 2)", {"code": "wrong-form", "given": "','"}, 2),
        ("turns(3)", {"code": "wrong-form", "given": "'('"}, 5),
        ("most(3)", {"code": "unknown-name", "name": "most"}, 0),
        ("turns.real", {"code": "wrong-form", "given": "'.'"}, 5),
        ("turns ** 2", {"code": "wrong-form", "given": "'*'"}, 7),
        ("1 + turns", {"code": "wrong-form"}, 0),
        ("1 + (turns > 3) > 2", {"code": "wrong-form"}, 5),
        ("3k", {"code": "unknown-name", "name": "k"}, 1),
    ],
)
def test_what_is_not_a_condition_is_refused_with_a_mark_under_it(text, expected, place):
    with raises(InvalidParameter, **expected) as caught:
        parse(text)
    assert str(caught.value).splitlines()[1:] == [f"  {text}", "  " + " " * place + "^"]


def test_a_long_expression_is_refused():
    with raises(InvalidParameter, "too-large", characters=2001):
        parse("1" * 2001)


_numbers = st.recursive(
    st.sampled_from(["turns", "detour", "2", "0.5"]),
    lambda inner: (
        st.builds(
            "({} {} {})".format, inner, st.sampled_from(["+", "-", "*", "/", "//", "%"]), inner
        )
        | st.builds("-{}".format, inner)
    ),
    max_leaves=5,
)


@given(_numbers)
def test_a_number_is_what_python_takes_it_for(text):
    try:
        expected = float(eval(text, dict(VALUES)))
    except ZeroDivisionError:
        assert parse(f"{text} == 1").violation(VALUES, RADIUS) == 2.0
    else:
        sign = "-" if expected < 0 else "+"
        assert parse(f"{text} == {sign}{abs(expected)!r}").holds(VALUES, RADIUS)


def test_an_expression_can_be_pickled():
    expression = parse("turns > 3 or detour < 2")
    assert pickle.loads(pickle.dumps(expression)).violation({"turns": 7}, RADIUS) == 0.0
