"""fdlibm's sine, cosine and arc tangent.

They have known bits, are near the true value, and are the same in the core and its reference.
"""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers import core_parts as fdlibm
from tests.reference.sim import fdlibm as reference

ANGLES = st.floats(-13.0, 13.0)

# x, and what Java 17's StrictMath returns for sin, cos and atan. First the boundaries of fdlibm's
# cases; then arguments for which a common Linux C library differs in the last bit of at least two
# of the three functions.
KNOWN = [
    (-0.0, "-0x0.0p+0", "0x1.0000000000000p+0", "-0x0.0p+0"),
    (0.2, "0x1.96dff233dd2bcp-3", "0x1.f5cb49577627ap-1", "0x1.94441f8f7260cp-3"),
    (-0.5, "-0x1.eaee8744b05f0p-2", "0x1.c1528065b7d50p-1", "-0x1.dac670561bb4fp-2"),
    (0.7853981633974483, "0x1.6a09e667f3bccp-1", "0x1.6a09e667f3bcdp-1", "0x1.54e04c05d06a0p-1"),
    (0.79, "0x1.6bb36c9347c8ep-1", "0x1.685e69c8569afp-1", "0x1.5654847fd2e00p-1"),
    (1.5707963267948966, "0x1.0000000000000p+0", "0x1.1a62633145c07p-54", "0x1.00fe987ed02ffp+0"),
    (-2.4, "-0x1.59d64f5c3d19bp-1", "-0x1.798bab490d185p-1", "-0x1.2d0ead6066396p+0"),
    (3.141592653589793, "0x1.1a62633145c07p-53", "-0x1.0000000000000p+0", "0x1.433b8a322ddd2p+0"),
    (4.5, "-0x1.f47ed3dc74080p-1", "-0x1.afb5b54583d6ap-3", "0x1.5a25052114e60p+0"),
    (6.283185307179586, "-0x1.1a62633145c07p-52", "0x1.0000000000000p+0", "0x1.69b8154baf42ep+0"),
    (
        34.55748874613524,
        "0x1.fec1340a0e388p-16",
        "-0x1.fffffffc04f9ap-1",
        "0x1.8ab7cd946a82fp+0",
    ),  # one piece of pi/2, according to the table
    (100.0, "-0x1.03425b78c4db8p-1", "0x1.b981dbf665fdfp-1", "0x1.8f905eb2def22p+0"),
    (823549.5, "-0x1.4f8bacd318ed0p-3", "0x1.f914ccf71fcccp-1", "0x1.921fa0e5121f7p+0"),
    (-5.157, "0x1.ce38ec3f05ee3p-1", "0x1.b86de7627257cp-2", "-0x1.611753ac55276p+0"),
    (0.9377, "0x1.9cc62cbab169ap-1", "0x1.2eebf13bcbf8cp-1", "0x1.81aafec8e3faep-1"),
    (-5.5356, "0x1.5c17eab2f9b6cp-1", "0x1.7777619f92272p-1", "-0x1.645f05d7a3369p+0"),
    (0.7597, "0x1.609dce4e13998p-1", "0x1.7338ca7306c7ep-1", "0x1.4ca2e41827ae0p-1"),
    (3.934, "-0x1.6c913e10de918p-1", "-0x1.677e0118cef89p-1", "0x1.5266571faeac4p+0"),
    (-5.4678, "0x1.74bb14baf7853p-1", "0x1.5f056211a27bdp-1", "-0x1.63d0ea7c89f33p+0"),
    (-3.6808, "0x1.06e3b33d94c43p-1", "-0x1.b75af913f9b39p-1", "-0x1.4e36824c690aap+0"),
]


def bits(value):
    return np.float64(value).tobytes()


@pytest.mark.parametrize(("x", "sine", "cosine", "arc"), KNOWN, ids=[str(row[0]) for row in KNOWN])
def test_the_bits_are_those_of_the_recorded_program(x, sine, cosine, arc):
    found = (fdlibm.sin(x), fdlibm.cos(x), fdlibm.atan(x))
    assert [bits(value) for value in found] == [
        bits(float.fromhex(text)) for text in (sine, cosine, arc)
    ]


@pytest.mark.parametrize("x", [math.inf, -math.inf, math.nan, 1e6, -1e6])
def test_angles_beyond_the_reduction_give_nan(x):
    assert math.isnan(fdlibm.sin(x)) and math.isnan(fdlibm.cos(x))


def test_arc_tangent_of_infinity_is_a_quarter_turn_and_of_nan_is_nan():
    assert (fdlibm.atan(math.inf), fdlibm.atan(-1e300)) == (math.pi / 2, -math.pi / 2)
    assert math.isnan(fdlibm.atan(math.nan))


def taylor(x, first):
    """Sum x**k/k! with alternating signs, in exact fractions, far below a double's last bit."""
    exact, term, total, k = Fraction(x), Fraction(1), Fraction(0), 0
    while k < 90:
        if k % 2 == first:
            total += term if (k // 2) % 2 == 0 else -term
        k += 1
        term = term * exact / k
    return total


@pytest.mark.gate
@given(ANGLES)
def test_sine_is_within_one_unit_in_the_last_place(x):
    true = taylor(x, 1)
    assert abs(Fraction(fdlibm.sin(x)) - true) <= Fraction(math.ulp(float(true)))


@given(ANGLES)
def test_cosine_is_within_one_unit_in_the_last_place(x):
    true = taylor(x, 0)
    assert abs(Fraction(fdlibm.cos(x)) - true) <= Fraction(math.ulp(float(true)))


@given(st.floats(-1e6, 1e6))
def test_arc_tangent_undoes_the_tangent(x):
    angle = fdlibm.atan(x)
    assert math.tan(angle) == pytest.approx(x, rel=1e-9) and abs(angle) <= math.pi / 2


@given(ANGLES, st.sampled_from(["sin", "cos", "atan"]))
def test_the_reference_has_the_same_bits(x, name):
    assert bits(getattr(fdlibm, name)(x)) == bits(getattr(reference, name)(x))


@given(ANGLES)
def test_symmetries_hold_exactly(x):
    assert (fdlibm.sin(-x), fdlibm.cos(-x), fdlibm.atan(-x)) == (
        -fdlibm.sin(x),
        fdlibm.cos(x),
        -fdlibm.atan(x),
    )
