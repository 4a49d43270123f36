"""Stage itself loads exported worlds.

Its ranger measures, and its robot stops, where the world has walls. Debian has no package; a build
from source is looked up in ``$WORLDGEN_CLIENTS/stage``, then on PATH.
"""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.clients.environments import FOLDER, SCRIPTS, program
from tests.helpers.core_parts import heading_table, ray_distance
from tests.helpers.drawn_worlds import drawn
from tests.reference.sim.layout import TURN, UNIT
from worldgen.generation import generate
from worldgen.interop import export_world, write_export
from worldgen.lattice import heading_to_lattice, metres_to_lattice

WHY = (
    "Stage is not here, so it did not judge what export writes; build github.com/rtv/Stage with "
    "cmake -DBUILD_PLAYER_PLUGIN=OFF -DCMAKE_INSTALL_PREFIX=$WORLDGEN_CLIENTS/stage"
)


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """Run an exported world in Stage, with the probe as its robot's controller.

    Lines by their first word.
    """
    found = FOLDER / "stage" / "bin" / "stage"
    path = str(found) if found.exists() else shutil.which("stage")
    if path is None:
        pytest.skip(WHY)
    prefix, folder = Path(path).resolve().parents[1], tmp_path_factory.mktemp("stage")
    include = next(iter(prefix.glob("include/Stage-*")))
    words = [
        "-O1",
        "-shared",
        "-fPIC",
        f"-I{include}",
        "-o",
        folder / "probe.so",
        SCRIPTS / "stage_probe.cc",
    ]
    subprocess.run([program("g++"), *map(str, words)], check=True, capture_output=True)

    def run(world, origin):
        out = write_export(
            export_world(world, "stage+lidar", file="w.world", origin=origin), folder, force=True
        )[0]
        out.write_text(out.read_text().replace('name "robot"', 'name "robot"\n  ctrl "probe"'))
        setting = {**os.environ, "STAGEPATH": str(folder), "LD_LIBRARY_PATH": str(prefix / "lib")}
        done = subprocess.run(
            [path, "-g", out.name],
            cwd=folder,
            env=setting,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        lines = [line.split() for line in done.stdout.splitlines() if line.strip()]
        return {
            words[0]: [float(word) for word in words[1:]]
            for words in lines
            if words[0] in ("POSE", "RANGES", "END")
        }

    return run


def ranges(world):
    """Return what our own beams measure at the start, m."""
    cells, table, longest = (
        world.walls.astype(np.uint8),
        heading_table(),
        10.0 / world.cell_size * UNIT,
    )
    place = [metres_to_lattice(value, world.cell_size) for value in (world.start.x, world.start.y)]
    ray, turned = (
        getattr(ray_distance, "py_func", ray_distance),
        heading_to_lattice(world.start.heading),
    )
    beams = [turned + beam * TURN // 256 - TURN // 2 for beam in range(257)]
    return (
        np.array([ray(cells, table, *place, beam, longest) for beam in beams])
        * world.cell_size
        / UNIT
    )


@pytest.mark.parametrize(("size", "origin"), [(13, (0.0, 0.0)), (20, (-31.5, 7.25))])
def test_stages_ranger_measures_what_ours_does_but_near_corners(stage, size, origin):
    """Stage casts rays through a raster of a tenth of a cell, and beams that graze a corner may
    continue or stop there.
    """
    world = generate("maze", 3, size=size)
    found = stage(world, origin)
    off = np.abs(np.array(found["RANGES"]) - ranges(world))
    assert found["POSE"][:2] == pytest.approx(
        [world.start.x + origin[0], world.start.y + origin[1]], abs=1e-9
    )
    assert np.mean(off < 0.02) > 0.85 and np.median(off) < 0.0125


@pytest.mark.parametrize(
    "drawing", ["########\n#......#\n#.S..G.#\n#......#\n########", "......\n.S..G.\n......"]
)
def test_stages_robot_stops_where_its_disc_meets_the_wall_or_the_ring(stage, drawing):
    world = drawn(drawing, robot_speed=0.5)
    stalled, x, y = stage(world, (10.5, -3.0))["END"]
    edge = 0.7 if "#" in drawing else 0.6
    assert stalled == 1.0 and y == pytest.approx(world.start.y - 3.0, abs=1e-6)
    assert x == pytest.approx(10.5 + edge - world.robot_radius, abs=0.021)  # a step and the raster
