"""fdlibm's sine, cosine and arc tangent: known bits, near the true value, same with and without numba."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.kernels import fdlibm

ANGLES = st.floats(-13.0, 13.0)


def taylor(x, first):
    """Sum of x**k/k! with alternating signs, in exact fractions, until far below a double's last bit."""
    exact, term, total, k = Fraction(x), Fraction(1), Fraction(0), 0
    while k < 90:
        if k % 2 == first:
            total += term if (k // 2) % 2 == 0 else -term
        k += 1
        term = term * exact / k
    return total


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
def test_the_python_twin_has_the_same_bits(x, name):
    function = getattr(fdlibm, name)
    twin = getattr(function, "py_func", function)
    assert np.float64(function(x)).tobytes() == np.float64(twin(x)).tobytes()


@given(ANGLES)
def test_symmetries_hold_exactly(x):
    assert (fdlibm.sin(-x), fdlibm.cos(-x), fdlibm.atan(-x)) == (-fdlibm.sin(x), fdlibm.cos(x), -fdlibm.atan(x))
