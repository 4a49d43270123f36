"""Text for terminals."""

import pytest

from worldgen.support.plain_text import alternatives, in_degrees, rounded, rounded_angle


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
