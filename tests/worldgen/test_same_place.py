"""A point of the world is the same point in every file that has coordinates."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.exported_meshes import TINY, any_worlds
from tests.helpers.exported_plans import CELLS_ONLY, PLANS
from worldgen.interop import FORMATS, export_world


def points(world, seed, *, outside):
    """Yield points in each cell and in the ring around an open border: solid or not."""
    solid = np.pad(world.walls, 1, constant_values=True)
    ring = 0 if not outside or (solid[[1, -2]].all() and solid[:, [1, -2]].all()) else 1
    random = np.random.Generator(np.random.PCG64(seed))
    for iy in range(-ring, world.height + ring):
        for ix in range(-ring, world.width + ring):
            x, y = random.uniform(-0.3, 0.3, 2) + 0.5  # inside the post that BARN makes from a cell
            yield bool(solid[iy + 1, ix + 1]), ix + x, iy + y


@pytest.mark.gate
@pytest.mark.parametrize("name", PLANS)
@settings(max_examples=15)
@given(any_worlds(), st.integers(0, 99))
def test_a_point_of_the_world_is_the_same_point_in_the_file(name, drawn, seed):
    world, (left, bottom) = drawn
    plan = PLANS[name](export_world(world, name, origin=(left, bottom)).files)
    outside = name not in ("ros", "tiled")  # theirs end where the grid ends
    for solid, x, y in points(world, seed, outside=outside):
        assert plan.solid(left + x * world.cell_size, bottom + y * world.cell_size) == solid
    if plan.start is not None:
        assert plan.start == pytest.approx((left + world.start.x, bottom + world.start.y), abs=1e-9)


def test_every_format_that_is_written_has_coordinates_to_check_or_none():
    written = {name for name in FORMATS if FORMATS.get(name).write is not None}
    checked = {name.partition("+")[0] for name in PLANS}
    assert checked | CELLS_ONLY == written and not checked & CELLS_ONLY


@pytest.mark.parametrize("name", PLANS)
def test_a_file_that_lies_a_cell_beside_is_told_apart(name):
    plan = PLANS[name](export_world(TINY, name, origin=(0.1, 0.0)).files)
    assert any(
        plan.solid(x * 0.1, y * 0.1) != solid for solid, x, y in points(TINY, 0, outside=False)
    )
