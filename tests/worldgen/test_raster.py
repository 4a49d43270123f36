"""Shapes become cells, and those that would take too long are refused at once."""

from fractions import Fraction

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen import FormatError
from worldgen.interop.geometry import raster
from worldgen.interop.geometry.raster import painted


def star(rays, radius=50.0):
    """Return the corners of a star of that many rays around (50, 50) m."""
    angle = np.arange(2 * rays) * np.pi / rays
    far = np.where(np.arange(2 * rays) % 2, radius, 1.0)
    return np.column_stack((50.0 + far * np.cos(angle), 50.0 + far * np.sin(angle)))


def test_a_star_of_many_rays_is_refused_before_anything_looks_for_crossings(monkeypatch):
    monkeypatch.setattr(raster, "_prepared", lambda points: pytest.fail("it was looked at"))
    side = Fraction(100)
    with raises(FormatError, "too-large"):
        painted((side, side), Fraction(1, 20), lambda grid: grid.polygon(star(20_000)))


def test_a_star_that_is_not_too_costly_is_painted():
    side = Fraction(100)
    found = painted((side, side), Fraction(1), lambda grid: grid.polygon(star(12)))
    # A star of n rays has n times the two radii times the sine of half the angle between rays.
    area = 12 * 50.0 * 1.0 * np.sin(np.pi / 12)
    assert np.count_nonzero(found.full) < area < np.count_nonzero(found.solid)
