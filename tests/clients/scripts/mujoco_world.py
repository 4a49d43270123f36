"""Load a model and answer a request.

Rays at given times, a dropped sphere, a driven robot.
"""

import importlib.util
import json
import sys
from pathlib import Path

import mujoco
import numpy as np

path, request = sys.argv[1], json.loads(Path(sys.argv[2]).read_text())


def player():
    beside = Path(path).with_name(Path(path).stem + "_player.py")
    spec = importlib.util.spec_from_file_location("player", beside)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def distances(model, data, rays, z):
    hit = np.zeros(1, np.int32)
    return [
        mujoco.mj_ray(model, data, [x, y, z], [along, across, 0.0], None, 1, -1, hit)
        for x, y, along, across in rays
    ]


def rays_at(time):
    """Cast rays at a given time, with a player that steps up to it and one that jumps there."""
    model = mujoco.MjModel.from_xml_path(path)
    played, jumped = mujoco.MjData(model), mujoco.MjData(model)
    if model.nmocap:
        module = player()
        module.play(model, played, time)
        jumped.time = time
        module.apply(model, jumped)
    mujoco.mj_kinematics(model, jumped)
    if not model.nmocap:
        mujoco.mj_kinematics(model, played)
    return [distances(model, data, request["rays"], request["z"]) for data in (played, jumped)]


def drop():
    x, y, z, radius = request["drop"]
    spec = mujoco.MjSpec.from_file(path)
    body = spec.worldbody.add_body(name="ball", pos=[x, y, z])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    while data.time < 3.0:
        mujoco.mj_step(model, data)
    return data.body("ball").xpos.tolist()


def drive():
    """Pose of the robot at the start and after each command: vx, vy, seconds."""
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    names = ("robot_x", "robot_y", "robot_heading")
    places = [[float(data.joint(name).qpos[0]) for name in names]]
    for vx, vy, seconds in request["drive"]:
        data.actuator("robot_vx").ctrl, data.actuator("robot_vy").ctrl = vx, vy
        until = data.time + seconds
        while data.time < until - 1e-9:
            mujoco.mj_step(model, data)
        places.append([float(data.joint(name).qpos[0]) for name in names])
    mujoco.mj_forward(model, data)
    return {"places": places, "shown": data.body("robot_disc").xpos[:2].tolist()}


def marks():
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    places = {
        name: [*data.site(name).xpos[:2].tolist(), float(model.site(name).size[0])]
        for name in ("start", "target")
    }
    turned = data.site("start").xmat[[0, 3]].tolist()
    numbers = ("cell_size", "origin", "robot_radius", "robot_speed")
    return {
        **places,
        "towards": turned,
        **{name: model.numeric(name).data.tolist() for name in numbers},
    }


def fleet():
    """Return the poses of the named robots, [x, y, heading], at the start and after all have driven
    along x.
    """
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)

    def places():
        return [
            [float(data.joint(f"{name}_{part}").qpos[0]) for part in ("x", "y", "heading")]
            for name in request["fleet"]
        ]

    begun = places()
    for name in request["fleet"]:
        data.actuator(f"{name}_vx").ctrl = 0.5
    while data.time < 0.2:
        mujoco.mj_step(model, data)
    return [begun, places()]


answer = {"version": mujoco.__version__}
if "rays" in request:
    answer["rays"] = [rays_at(time) for time in request["times"]]
if "drop" in request:
    answer["drop"] = drop()
if "drive" in request:
    answer["drive"] = drive()
if "fleet" in request:
    answer["fleet"] = fleet()
if "marks" in request:
    answer["marks"] = marks()
print(json.dumps(answer))
