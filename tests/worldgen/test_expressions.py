"""The numbers in conditions: their values, and errors with a mark under the place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.parameters.expressions import Language, evaluate, parse_condition, variables_in

FORMULAS = Language(("size", "least"), "parameter", 80, "size > 2", units={"k": "k"})
VALUES = {"size": 7, "least": 5, "k": 1000}


def number(text):
    """Return the left side of a comparison."""
    return parse_condition(f"{text} > 0", FORMULAS).operands[0]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("size // 2 - 3", 0),
        (" -size % 4", 1),
        ("least + 1", 6),
        ("2 * ((size + least) - 1)", 22),
        ("1.5k / 2", 750.0),
    ],
)
def test_a_number_s_value(text, value):
    assert evaluate(number(text), VALUES) == value


def test_whole_numbers_stay_whole():
    assert repr(evaluate(number("size * 9007199254740993"), VALUES)) == str(7 * 9007199254740993)


@pytest.mark.parametrize(
    ("text", "expected", "place"),
    [
        ("()", {"code": "wrong-form", "came": "')'"}, 1),
        ("(1", {"code": "wrong-form", "came": "the end"}, 2),
        ("(1, 2)", {"code": "wrong-form", "came": "','"}, 2),
        ("size(3)", {"code": "wrong-form", "came": "'('"}, 4),
        ("most(3)", {"code": "unknown-name", "name": "most"}, 0),
        ("size.real", {"code": "wrong-form", "came": "'.'"}, 4),
        ("size ** 2", {"code": "wrong-form", "came": "'*'"}, 6),
        ("1 + size", {"code": "wrong-form"}, 0),
        ("1 + (size > 3) > 2", {"code": "wrong-form"}, 5),
        ("3m", {"code": "unknown-name", "name": "m", "known": "k"}, 1),
    ],
)
def test_what_is_not_a_condition_is_refused_with_a_mark_under_it(text, expected, place):
    with raises(InvalidParameter, **expected) as caught:
        parse_condition(text, FORMULAS)
    assert str(caught.value).splitlines()[1:] == [f"  {text}", "  " + " " * place + "^"]


def test_a_long_expression_is_refused():
    with raises(InvalidParameter, "too-large", characters=81, most=80):
        parse_condition("1" * 81, FORMULAS)


_numbers = st.recursive(
    st.sampled_from(["size", "least", "2", "0.5"]),
    lambda inner: (
        st.builds(
            "({} {} {})".format, inner, st.sampled_from(["+", "-", "*", "/", "//", "%"]), inner
        )
        | st.builds("-{}".format, inner)
    ),
    max_leaves=5,
)


@pytest.mark.gate
@given(_numbers)
def test_a_number_is_what_python_takes_it_for(text):
    if len(text) > FORMULAS.longest - len(" > 0"):
        return
    node = number(text)
    assert set(variables_in(node)) <= set(VALUES)
    names = {"size": 7, "least": 5}
    try:
        expected = eval(text, names)
    except ZeroDivisionError:
        with pytest.raises(ZeroDivisionError):
            evaluate(node, VALUES)
    else:
        assert evaluate(node, VALUES) == expected
