"""Drive a ball through an exported world in MuJoCo and record it for ``worldgen audit``.

python mujoco_drive.py wall.xml --speed 20 --out recorded.csv

It only needs mujoco. Start, target and the ball's radius come from the file. The ball weighs 1 kg,
floats just above the floor, and is pushed towards the next point of its path by a force that
corrects its velocity. It prints one JSON object: versions, samples, and in how many steps MuJoCo
had a contact between the ball and anything else.
"""

import argparse
import csv
import json
import math
import sys
from pathlib import Path

import mujoco

# Gain of the force that corrects the velocity, N s/m.
GAIN = 200.0
# Largest force, N.
MOST_FORCE = 200.0


def with_ball(file, radius, start, time_step):
    """Return the exported world with a ball that slides along x and y."""
    spec = mujoco.MjSpec.from_file(str(file))
    if time_step:
        spec.option.timestep = time_step
    ball = spec.worldbody.add_body(name="ball", pos=[start[0], start[1], 1.05 * radius])
    for axis in ([1, 0, 0], [0, 1, 0]):
        ball.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    ball.add_geom(name="ball", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], mass=1.0)
    return spec.compile()


def drive(model, way, speed, seconds):
    """Return the trajectory as rows t, x, y, and the steps in which the ball touched something.

    Also return whether the ball arrived.
    """
    # Start at full speed.
    data = mujoco.MjData(model)
    rows = []
    touched = 0
    start = way.pop(0)
    step = model.opt.timestep
    data.qvel[:] = [speed * part for part in _direction(start, way[0])]
    near = max(0.05, 0.5 * speed * step)
    # Steer towards the next point of the path by a force that corrects the velocity.
    for _ in range(int(seconds / step) + 1):
        place = (start[0] + float(data.qpos[0]), start[1] + float(data.qpos[1]))
        rows.append((float(data.time), *place))
        while len(way) > 1 and math.dist(place, way[0]) < near:
            del way[0]
        if math.dist(place, way[0]) < near:
            return rows, touched, True
        wanted = [speed * part for part in _direction(place, way[0])]
        missing = [GAIN * (wish - float(now)) for wish, now in zip(wanted, data.qvel, strict=True)]
        data.qfrc_applied[:] = [max(-MOST_FORCE, min(MOST_FORCE, force)) for force in missing]
        mujoco.mj_step(model, data)
        touched += data.ncon > 0
    return rows, touched, False


def _direction(here, there):
    length = math.dist(here, there)
    return (there[0] - here[0]) / length, (there[1] - here[1]) / length


def main():
    """Drive, write, and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("world", help="what `worldgen export --to mjcf` wrote")
    parser.add_argument(
        "--via", nargs="*", default=[], metavar="X,Y", help="places on the way to the target, m"
    )
    parser.add_argument("--speed", type=float, default=1.0, help="m/s")
    parser.add_argument("--time-step", type=float, help="s [default: the file's]")
    parser.add_argument("--seconds", type=float, default=20.0, help="at most")
    parser.add_argument("--out", required=True, help="CSV: t,x,y")
    given = parser.parse_args()
    via = [tuple(float(number) for number in place.split(",")) for place in given.via]
    # The export names the start and the target as sites.
    world = mujoco.MjModel.from_xml_path(given.world)
    start, target = (tuple(map(float, world.site(name).pos[:2])) for name in ("start", "target"))
    model = with_ball(
        given.world, float(world.numeric("robot_radius").data[0]), start, given.time_step
    )
    rows, touched, arrived = drive(model, [start, *via, target], given.speed, given.seconds)
    # The audit reads times and positions from this table.
    with Path(given.out).open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("t", "x", "y"))
        table.writerows([f"{value:.9g}" for value in row] for row in rows)
    said = {"simulator": f"mujoco {mujoco.__version__}", "samples": len(rows), "arrived": arrived}
    sys.stdout.write(json.dumps(said | {"contacts": touched}) + "\n")


if __name__ == "__main__":
    main()
