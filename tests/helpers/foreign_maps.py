"""A few small maps in every format that a census accepts, drawn once."""

import numpy as np

from worldgen import Pose, Target, World, write_world
from worldgen.support.rows import flip_rows

# A gap of one cell between two halls; a disc with a radius of more than half a cell does not fit
# through.
GAP = ("#########", "#...#...#", "#...#...#", "#.......#", "#...#...#", "#...#...#", "#########")
START, TARGET = (3, 1), (3, 7)  # row from the top, column


def solid(rows=GAP):
    """(height, width) bool, top row first."""
    return np.array([[letter == "#" for letter in row] for row in rows])


def with_places(rows=GAP, start=START, target=TARGET):
    """The drawing with S and G."""
    letters = [list(row) for row in rows]
    letters[start[0]][start[1]], letters[target[0]][target[1]] = "S", "G"
    return ["".join(row) for row in letters]


def write_text(path, rows=GAP):
    path.write_text("\n".join(rows) + "\n")


def write_octile(path, rows=GAP):
    lines = ["type octile", f"height {len(rows)}", f"width {len(rows[0])}", "map", *rows]
    path.write_text("\n".join(lines).replace("#", "@") + "\n")


def write_scenario(path, name, rows=GAP, start=START, target=TARGET):
    places = [start[1], start[0], target[1], target[0]]
    row = [0, f"maps/{name}", len(rows[0]), len(rows), *places, 6.0]
    path.write_text("version 1\n" + "\t".join(map(str, row)) + "\n")


def write_ros(folder, name, rows=GAP, cell_size=0.05):
    grey = np.where(solid(rows), 0, 254).astype(np.uint8)
    header = f"P5\n{grey.shape[1]} {grey.shape[0]}\n255\n".encode()
    (folder / f"{name}.pgm").write_bytes(header + grey.tobytes())
    lines = [f"image: {name}.pgm", f"resolution: {cell_size}", "origin: [0, 0, 0]", "negate: 0"]
    (folder / f"{name}.yaml").write_text(
        "\n".join([*lines, "occupied_thresh: 0.65", "free_thresh: 0.196"]) + "\n"
    )


def gap_world(rows=GAP):
    """The same as a world, start and target at the centres of the usual cells."""
    height = len(rows)
    at, to = (((column + 0.5) / 10, (height - row - 0.5) / 10) for row, column in (START, TARGET))
    return World(flip_rows(solid(rows)), Pose(*at), Target(*to, 0.05))


def write_each_kind(folder):
    """Five maps of the gap: drawing, MovingAI with a scenario, NumPy, ROS, ``.grid``.

    Three of them have start and target.
    """
    write_text(folder / "drawn.txt", with_places())
    write_octile(folder / "octile.map")
    write_scenario(folder / "octile.map.scen", "octile.map")
    np.save(folder / "array.npy", solid())
    write_ros(folder, "hall")
    write_world(gap_world(), folder / "ours.grid")
