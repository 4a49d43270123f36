"""The physics of Gazebo Fortress, dartsim, checks the output of ``export --to sdf``, through a
small program.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.clients.environments import SCRIPTS, program
from tests.clients.install import FOLDER, PROGRAMS
from tests.helpers.drawn_worlds import drawn
from tests.helpers.exact_rays import solid_at
from worldgen import generate
from worldgen.interop import export_world
from worldgen.timeline import CellState, Timeline

ORIGIN = (-12.7, 3.45)
BALL = 0.02  # m
LIBRARIES = (
    "sdformat12", "ignition-plugin1-loader", "ignition-math6-eigen3", "ignition-utils1", "ignition-transport11",
    "ignition-msgs8",
)  # fmt: skip
HALL = """
    ##########
    #........#
    #.S.....##
    #........#
    #G.......#
    ##########"""
WALL = 0.8  # m: where the wall on the right begins, in the start's row


def _flags():
    """Return the compiler flags for Fortress's libraries.

    None if they are not installed.
    """
    if shutil.which("pkg-config") is None:
        return None
    words = ["pkg-config", "--cflags", "--libs", *LIBRARIES]
    asked = subprocess.run(words, capture_output=True, text=True, check=False)
    return None if asked.returncode else [*asked.stdout.split(), "-I/usr/include/ignition/physics5"]


@pytest.fixture(scope="module")
def engine():
    """Return the command that runs the program, which is compiled once for its text."""
    compiler, flags = program("g++"), _flags()
    plugins = sorted(Path("/usr/lib").glob("*/libignition-physics5-dartsim-plugin.so"))
    if flags is None or not plugins:
        pytest.skip(
            f"Fortress's physics is not here, so it judged nothing; apt-get install "
            f"{PROGRAMS['g++']}"
        )
    source = SCRIPTS / "gazebo_physics.cc"
    binary = FOLDER / f"gazebo-physics-{hashlib.sha256(source.read_bytes()).hexdigest()[:12]}"
    if not binary.exists():
        FOLDER.mkdir(parents=True, exist_ok=True)
        fresh = binary.with_suffix(f".{os.getpid()}")
        subprocess.run(
            [compiler, "-std=c++17", "-w", source, "-o", fresh, *flags, "-lignition-physics5"],
            check=True,
        )
        fresh.rename(binary)
    return [binary, plugins[0]]


def obeyed(engine, tmp_path, world, name, commands):
    """Return where things are after these commands, as reported by the program."""
    for file, data in export_world(
        world, name, file="world.sdf", origin=ORIGIN, sidecar=False
    ).files.items():
        (tmp_path / file).write_bytes(data)
    text = "".join(f"{command}\n" for command in commands)
    done = subprocess.run(
        [*engine, tmp_path / "world.sdf"], input=text, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


def dropped(world, cells):
    """Return commands that drop a ball on the middle of each cell, and report where the balls are a
    second later.
    """
    for ix, iy in cells:
        x, y = (
            (index + 0.5) * world.cell_size + corner
            for index, corner in zip((ix, iy), ORIGIN, strict=True)
        )
        yield f"ball ball_{ix}_{iy} {x!r} {y!r} 1.1 {BALL}"
    yield "step 1000"
    yield from (f"where ball_{ix}_{iy}" for ix, iy in cells)


def rests(solid, cells):
    """Heights at which balls lie: on walls 1 m high, or on the floor."""
    return [BALL + (1.0 if solid[iy, ix] else 0.0) for ix, iy in cells]


def test_balls_lie_on_walls_and_on_the_floor_where_the_cells_say(engine, tmp_path):
    world = generate("cave", seed=5, size=24)
    random = np.random.Generator(np.random.PCG64(1))
    cells = [(int(ix), int(iy)) for ix, iy in random.choice(24, size=(40, 2))]
    cells = list(dict.fromkeys(cells))
    heights = [place[2] for place in obeyed(engine, tmp_path, world, "sdf", dropped(world, cells))]
    assert heights == pytest.approx(rests(world.walls, cells), abs=1e-4)
    assert len({round(height) for height in heights}) == 2


def test_a_ball_that_is_pushed_stops_at_the_wall(engine, tmp_path):
    world = drawn(HALL)
    x, y = world.start.x + ORIGIN[0], world.start.y + ORIGIN[1]
    commands = [f"ball pushed {x!r} {y!r} {BALL} {BALL}", "push pushed 0.5 0 2000", "where pushed"]
    found = obeyed(engine, tmp_path, world, "sdf", commands)[0]
    assert found == pytest.approx([ORIGIN[0] + WALL - BALL, y, BALL], abs=2e-3)


def test_the_robot_rolls_as_fast_as_its_wheels_and_stops_at_the_wall(engine, tmp_path):
    world = drawn(HALL)
    x, y = world.start.x + ORIGIN[0], world.start.y + ORIGIN[1]
    commands = [
        "step 200",
        "where robot",
        "wheels 4 4 1000",
        "where robot",
        "wheels 20 20 2000",
        "where robot",
    ]
    start, rolled, stopped = obeyed(engine, tmp_path, world, "sdf+robot+plugins=fortress", commands)
    assert start[:2] == pytest.approx([x, y], abs=1e-4)
    assert rolled[:2] == pytest.approx([x + 4 * world.robot_radius / 2, y], abs=2e-3)
    assert stopped[:2] == pytest.approx([ORIGIN[0] + WALL - world.robot_radius, y], abs=2e-3)


@pytest.mark.parametrize(("family", "time"), [("shift", 6.0), ("fire", 3.0)])
def test_models_that_are_moved_as_the_table_says_make_the_cells_of_that_time(
    engine, tmp_path, family, time
):
    world = generate(family, seed=5, size=14, **({"chance": 1.0} if family == "shift" else {}))
    files = export_world(world, "sdf", file="world.sdf", origin=ORIGIN).files
    table = json.loads(files["world_events.json"])
    late = {name: z for when, name, z in table["events"] if when <= time}
    moves = ["move {} {} {} {}".format(name, *table["bodies"][name], z) for name, z in late.items()]
    changing = sorted({(event.ix, event.iy) for event in world.timeline if event.time <= time})[::5]
    places = obeyed(engine, tmp_path, world, "sdf", [*moves, *dropped(world, changing)])
    assert [place[2] for place in places] == pytest.approx(
        rests(solid_at(world, time), changing), abs=1e-4
    )


def command_folder(tmp_path):
    """A folder with a working ``ign``, because Debian 12's looks for the transport tools in the
    wrong place.
    """
    tools = Path("/usr/libexec/ignition/transport11")
    if not (tools / "ign-transport-service").exists():
        pytest.skip(f"ign service is not here; apt-get install {PROGRAMS['ign-transport-service']}")
    command = tmp_path / "bin" / "ign"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nkind=$1\nshift\nexec {tools}/ign-transport-$kind "$@"\n')
    command.chmod(0o755)
    return command.parent


def test_the_player_talks_to_gazebo_in_its_own_messages(engine, tmp_path):
    events = [
        (0.25, 7, 2, CellState.SOLID),
        (0.25, 1, 1, CellState.BURNING),
        (1.5, 7, 2, CellState.FREE),
    ]
    files = export_world(
        drawn(HALL, timeline=Timeline.of(events)), "sdf", file="hall.sdf", sidecar=False
    ).files
    for file, data in files.items():
        (tmp_path / file).write_bytes(data)
    here = {**os.environ, "IGN_PARTITION": tmp_path.name, "IGN_IP": "127.0.0.1"}
    here["PATH"] = f"{command_folder(tmp_path)}:/bin"
    with subprocess.Popen(
        [*engine, tmp_path / "hall.sdf"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=here,
    ) as server:
        server.stdin.write("serve hall\n")
        server.stdin.close()
        try:
            player = [sys.executable, tmp_path / "hall_player.py"]
            done = subprocess.run(
                player, env=here, capture_output=True, text=True, check=False, timeout=60
            )
            assert done.returncode == 0, done.stderr
            moved = [line.split() for line in server.stdout]
        finally:
            server.kill()
    table = json.loads(files["hall_events.json"])["events"]
    assert [[float(when), name, float(z)] for when, name, z in moved] == [
        [when, name, z] for when, name, z in table
    ]
