"""Text for terminals."""

import pytest

from worldgen.errors import InvalidParameter
from worldgen.support.plain_text import (
    aligned,
    alternatives,
    in_degrees,
    joined,
    printed,
    rounded,
    rounded_angle,
    shown,
    stacked,
    styled,
)


@pytest.mark.parametrize(
    ("angle", "text"),
    [
        (0.0, "0 degrees"),
        (360 / 65536, "less than 0.01 degrees"),
        (-360 / 65536, "less than 0.01 degrees"),
        (2 * 360 / 65536, "0.01 degrees"),
        (0.0994, "0.1 degrees"),
        (1.0, "1 degree"),
        (2.584, "2.58 degrees"),
        (42.56, "42.6 degrees"),
        (1234.4, "1,234 degrees"),
    ],
)
def test_an_angle_has_three_digits_and_at_most_two_decimals(angle, text):
    assert in_degrees(angle) == text


def test_a_choice_names_each_once():
    assert [alternatives("abc"[:n]) for n in range(4)] == ["", "a", "a or b", "a, b or c"]


def test_a_long_path_has_no_exponent():
    assert [rounded(length, 2) for length in (0.0, 0.0451, 1.26, 112.3, 4567.0)] == [
        "0", "0.045", "1.3", "110", "4,600",
    ]  # fmt: skip


def test_neither_a_huge_nor_a_tiny_number_has_an_exponent():
    numbers = ((1234567.0, 3), (0.00001234, 2), (-0.0996, 2), (999.6, 3))
    assert [rounded(*one) for one in numbers] == ["1,230,000", "0.000012", "-0.1", "1,000"]


def test_a_tiny_angle_among_others_is_zero():
    assert rounded_angle(-0.001) == "0"


# Controls of C0 and C1, marks that reorder, join or hide text, line ends, a tag, a lone surrogate.
HARMFUL = (
    *(0x1B, 0x0A, 0x0D, 0x08, 0x7F, 0x85, 0x9B, 0x200B, 0x200D, 0x202E, 0x2066, 0x2028),
    *(0xFEFF, 0x3164, 0xFE0F, 0xE0041, 0xD800),
)


@pytest.mark.parametrize("sign", [*map(chr, HARMFUL)], ids=[f"U+{code:04X}" for code in HARMFUL])
def test_a_character_that_a_terminal_obeys_or_hides_becomes_an_escape(sign):
    text = shown(f"a{sign}b")
    assert text.isascii() and text.isprintable()
    assert text.startswith("a\\") and text.endswith("b")


@pytest.mark.parametrize("text", ["plain", "Überweg 7 µm", "地図", "a\\b", "[red]x[/red]", "a::b"])
def test_text_that_harms_nobody_stays(text):
    assert shown(text) == text == printed(text)


@pytest.mark.parametrize("text", ["::error::x", "  ::x::", "\t::x", "a ##[group]", "##vso[x]"])
def test_a_command_of_a_ci_service_becomes_text(text):
    for safe in (printed(text), printed(stacked(["first", text]))):
        last = safe.split("\n")[-1].lstrip()
        assert not last.startswith("::") and "##" not in last


def test_colours_of_ours_survive_and_others_become_text():
    line = joined("\x1b[31mfrom ", styled("a\x1b[0mstranger", "31;1"), "\x9b")
    assert printed(line) == "\\x1b[31mfrom \x1b[31;1ma\\x1b[0mstranger\x1b[0m\\x9b"


def test_a_line_cannot_break_itself():
    assert printed("a\nb") == "a\\nb"
    assert stacked(["a\nb", "c"]) == "a\\nb\nc"
    assert aligned([["a\nb", "c"], ["d", "e"]]) == "a\\nb  c\nd     e"


def test_a_fact_of_an_error_is_safe_and_stays_as_it_came():
    error = InvalidParameter(
        "code", "no {what} like {name!q} in {file}", what="x\x1b", name="\x9b", file="a\n"
    )
    assert str(error) == "no x\\x1b like '\\x9b' in a\\n"
    assert error.message.facts["file"] == "a\n"
