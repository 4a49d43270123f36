"""GDAL checks the output of ``export --to geojson``."""

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from tests.clients.environments import program
from tests.helpers.exported_meshes import TINY, covered_cells
from worldgen import generate
from worldgen.interop import export_world
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState, Timeline

ORIGIN = (-12.7, 3.45)
FINE = 4  # points per cell along each side


def written(folder, world):
    """The exported file."""
    path = folder / "w.geojson"
    path.write_bytes(export_world(world, "geojson", origin=ORIGIN, sidecar=False).data)
    return path


def ran(name, *words):
    done = subprocess.run(
        [program(name), *map(str, words)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("family", ["maze", "cave", "rubble"])
def test_points_lie_in_the_walls_as_cells_do(tmp_path, family):
    world = generate(family, seed=5, size=31)
    path, raster = written(tmp_path, world), tmp_path / "w.raw"
    ends = [ORIGIN[0], ORIGIN[1], ORIGIN[0] + world.width * 0.1, ORIGIN[1] + world.height * 0.1]
    size = ["-ts", world.width * FINE, world.height * FINE]
    within = ["-where", "kind='walls'", "-l", "w"]
    ran(
        "gdal_rasterize",
        "-q",
        "-burn",
        1,
        "-ot",
        "Byte",
        "-of",
        "ENVI",
        "-te",
        *ends,
        *size,
        *within,
        path,
        raster,
    )
    cells = np.frombuffer(raster.read_bytes(), np.uint8).reshape(world.height * FINE, -1)
    assert np.array_equal(flip_rows(cells), np.kron(world.walls, np.ones((FINE, FINE))))


def test_the_walls_are_valid_and_their_area_is_that_of_the_cells(tmp_path):
    for world in (generate("cave", seed=5, size=31), TINY):
        path = written(tmp_path, world)
        sql = "SELECT SUM(ST_Area(geometry)) AS area, MIN(ST_IsValid(geometry)) AS valid FROM w"
        said = ran("ogrinfo", "-q", "-dialect", "sqlite", "-sql", sql, path)
        assert re.search(r"valid \(Integer\) = (\d)", said)[1] == "1"
        area = float(re.search(r"area \(Real\) = (.+)", said)[1])
        assert area == pytest.approx(covered_cells(world) * world.cell_size**2, rel=1e-12)


def test_places_and_changes_are_features_with_what_belongs_to_them(tmp_path):
    line = Timeline.of([(1.5, 2, 1, CellState.BURNING), (4.25, 2, 1, CellState.FREE)])
    said = ran("ogrinfo", "-q", "-al", written(tmp_path, replace(TINY, timeline=line)))
    assert re.findall(r"POINT \((.+)\)", said) == ["-12.55 3.6", "-12.35 3.6"]
    assert re.findall(r"heading \(Real\) = (.+)", said) == ["0.5"]
    assert re.findall(r"time \(Real\) = (.+)", said) == ["1.5", "4.25"]
    assert re.findall(r"state \(String\) = (.+)", said) == ["burning", "free"]
