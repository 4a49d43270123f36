"""What a page needs to judge a world itself: the C cores as WebAssembly, and the recipe of a run.

``page/live/`` calls the cores. What no edit changes is computed here, once: the settings of the
run, its pushes and events, the controller's memory. A page only replaces what an edit can change,
so it needs to know little of the options.
"""

from __future__ import annotations

import base64
import functools
import gzip
import math
import re
import subprocess
import sys
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from sim._core import ffi
from sim.controllers.base import CompiledController, Controller
from sim.controllers.core_act import CoreAct
from sim.motion import MOTIONS
from sim.options.disturbances import pushes_of
from sim.options.run import COVER, MAX_STEPS, RunOptions, recorded_budget
from sim.runners.lattice import LatticeRun
from sim.runners.packing import event_step
from worldgen.reach.body.core_calls import Body
from worldgen.reach.body.prove import goal_headings
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState
from worldgen.world import Robot, Target, World

FREE, SOLID, BURNING = CellState
# JavaScript's numbers hold every integer below this.
_WHOLE = 2**53
# What build_tools/wasm.py makes of the cores.
_MODULE = "_core.wasm"
_FOLDER = "live"
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "#player/live/(\w+)\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:const|function|class) (\w+))", re.MULTILINE)
_COMMENT = re.compile(r"^ *(?:/\*\*(?:(?!\*/).)*\*/|//[^\n]*)\n", re.MULTILINE | re.DOTALL)


@functools.cache
def live_core() -> dict[str, str] | None:
    """Return the cores for pages and the script of their worker, each as base64 of gzip.

    A checkout compiles the cores when they are first wanted, which takes about 20 s. Return
    ``None`` if there are none: they take the compiler ``ziglang``.
    """
    modules = [files(package) / _MODULE for package in ("worldgen", "sim")]
    if not all(module.is_file() for module in modules):
        _compile_in_checkout()
    if not all(module.is_file() for module in modules):
        return None
    prover, simulator = (_packed(module.read_bytes()) for module in modules)
    script = _packed(worker_script().encode("utf-8"))
    return {"prover": prover, "simulator": simulator, "script": script}


def _compile_in_checkout() -> None:
    """Compile the cores for pages, if their sources and the compiler are there."""
    root = Path(__file__).parents[2]
    if (root / "build_tools" / "wasm.py").is_file() and find_spec("ziglang") is not None:
        command = [sys.executable, "-m", "build_tools.wasm"]
        # What the compiler says is for developers, who run this themselves.
        subprocess.run(command, cwd=root, check=False, capture_output=True)


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")


def without_comments(script: str) -> str:
    """Return a script without the comments that fill whole lines, a fifth of it."""
    return _COMMENT.sub("", script)


def worker_script() -> str:
    """Return the modules of the worker as one script.

    A worker that is made from a page's own text has no import map, so nothing in it can import.
    Each module is a function that returns what it exports.
    """
    folder = files("fuzz.player") / "page" / _FOLDER
    texts: dict[str, str] = {}

    def take(name: str) -> None:
        text = (folder / f"{name}.js").read_text("utf-8")
        # What a module imports comes before it.
        for _, other in _IMPORT.findall(text):
            if other not in texts:
                take(other)
        exported = ", ".join(_EXPORT.findall(text))
        own = _EXPORT.sub("", _IMPORT.sub(r"const \1 = of_\2;\n", without_comments(text)))
        texts[name] = f"const of_{name} = (() => {{\n{own}return {{ {exported} }};\n}})();\n"

    take("worker")
    return '"use strict";\n' + "".join(texts.values())


def live_question(
    world: World, controller: Controller | None, options: RunOptions | None
) -> dict[str, Any]:
    """Return a world and a run as a page judges them, and edited copies of the world.

    Args:
        world: The world.
        controller: The controller; ``None`` if only the proof is wanted.
        options: Options of the run; ``None`` without a controller.

    Returns:
        ``world``; ``run``, the recipe, or ``None`` if a page cannot run it; and ``why``, the
        sentence that says so.
    """
    why = "" if controller is None or options is None else why_not_live(world, controller, options)
    recipe = None
    if controller is not None and options is not None and not why:
        recipe = _recipe(world, controller, options)
    return {"world": live_world(world), "run": recipe, "why": why}


def live_world(world: World) -> dict[str, Any]:
    """Return a world as pages edit it: with lengths in m, as in its file."""
    robot = world.robots[0]
    found: dict[str, Any] = {
        "cells": [
            "".join("#" if solid else "." for solid in row) for row in flip_rows(world.walls)
        ],
        "cell_size": world.cell_size,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        "radius": world.robot_radius,
        "speed": world.robot_speed,
    }
    if not robot.is_disc:
        found |= {"body": _live_body(world), "headings": goal_headings(robot.target)}
    if robot.drive.is_car:
        drive = robot.drive
        found["headings"] = goal_headings(robot.target)
        found["car"] = {
            "turning_radius": drive.turning_radius,
            "reverse": drive.reverse,
            "steering_rate": drive.steering_rate,
        }
    if robot.waypoints:
        found["waypoints"] = [_live_goal(goal, robot) for goal in robot.waypoints]
    if world.is_dynamic:
        line, shape = world.timeline, world.walls.shape
        found["changes"] = {
            "closes": _places(line.cells_that_become(SOLID, BURNING, shape=shape)),
            "opens": _places(line.cells_that_become(FREE, BURNING, shape=shape)),
        }
    if world.is_fleet:
        found["robots"] = len(world.robots)
    return found


def _places(cells: Bools) -> list[list[int]]:
    """Return the cells that are set: column and row, 0 the lowest."""
    return [[int(ix), int(iy)] for iy, ix in np.argwhere(cells)]


def _live_body(world: World) -> dict[str, Any]:
    """Return a footprint on the lattice, and the discs that decide most worlds for it, m."""
    body = Body(world.walls, world.robots[0].footprint, world.cell_size)
    return {
        "corners": body.corners.tolist(),
        "inside": body.disc(outer=False),
        "around": body.disc(outer=True),
    }


def _live_goal(goal: Target, robot: Robot) -> dict[str, Any]:
    headings = {} if robot.is_disc else {"headings": goal_headings(goal)}
    return {"target": [goal.x, goal.y, goal.radius], **headings}


def has_live_proof(world: World) -> bool:
    """Return True if a page can decide whether the target of an edited world can be reached."""
    return not world.is_fleet


def why_not_live(world: World, controller: Controller, options: RunOptions) -> str:
    """Return why a page cannot run a controller, in a sentence for its reader; empty if it can."""
    if world.is_fleet:
        return "Several robots at once run only in worldgen."
    act = controller.act if isinstance(controller, CompiledController) else None
    if not isinstance(act, CoreAct) or type(act) is not CoreAct:
        return "This controller runs only in worldgen: the run is the recording."
    if options.task == COVER:
        return "Coverage is judged only in worldgen: the run is the recording."
    return ""


def _recipe(world: World, controller: Controller, options: RunOptions) -> dict[str, Any]:
    """Return everything about a run that an edit of its world leaves as it is."""
    robot = options.robot
    pushes = pushes_of(robot)
    budget = recorded_budget(world, options)
    own = _on_lattice if MOTIONS.get(options.motion).on_lattice else _stepped
    return {
        "motion": options.motion,
        "time_step": options.time_step,
        "tolerance": options.motion_model().overlap_tolerance,
        "steps": options.steps,
        "budget": {
            "factor": budget.witnesses,
            "fewest": budget.fewest,
            "most": MAX_STEPS,
            "moved": robot.moved,
            "drift": robot.drift,
            "pushed": sum(math.hypot(push.dx, push.dy) for push in pushes),
            "last_push": max((push.time for push in pushes), default=0.0),
        },
        **own(world, controller, options),
    }


def _on_lattice(world: World, controller: Controller, options: RunOptions) -> dict[str, Any]:
    run = LatticeRun(world, controller, options)
    settings = run.settings
    settings.digest = 1
    memory = run.controller.memory
    return {
        "controller": run.controller.act.name,
        "finds_loops": run.can_loop,
        "start_speed": _number(run.host.start_speed),
        "memory": {
            "size": len(memory),
            "numbers": [[k, _number(value)] for k, value in enumerate(memory) if value],
        },
        "settings": _fields(settings[0]),
        "pushes": _rows(settings.pushes, settings.push_count),
        "decoys": _rows(settings.decoys, settings.decoy_count),
        "events": run.events.tolist(),
    }


def _stepped(world: World, controller: Controller, options: RunOptions) -> dict[str, Any]:
    # Loaded for `stepped` only.
    from sim.thesis.run import ThesisRun  # noqa: PLC0415

    run = ThesisRun(world, controller, options)
    thesis = options.thesis
    return {
        "finds_loops": not thesis.random,
        "setup": {name: _number(value) for name, value in run.setup._asdict().items()},
        "noise": thesis.noise,
        "seed": str(options.seed),
        "draws": list(thesis.draws),
        "events": [
            [event_step(event, options.time_step), event.ix, event.iy, int(event.state)]
            for event in world.timeline
        ],
    }


def _fields(struct: Any, prefix: str = "") -> dict[str, Any]:
    """Return the fields of a struct that are not zero, without pointers.

    Those of a struct in it have names like ``footprint.count``; an array of structs is a list.
    """
    found: dict[str, Any] = {}
    for name, field in ffi.typeof(struct).fields:
        value = getattr(struct, name)
        path = f"{prefix}{name}"
        if field.type.kind == "struct":
            found |= _fields(value, f"{path}.")
        elif field.type.kind == "array":
            is_plain = field.type.item.kind == "primitive"
            items: list[Any] = [_number(item) if is_plain else _fields(item) for item in value]
            if any(items):
                found[path] = items
        elif field.type.kind == "primitive" and value:
            found[path] = _number(value)
    return found


def _rows(structs: Any, count: int) -> list[list[Any]]:
    """Return structs of numbers as rows."""
    return [
        [_number(getattr(structs[k], name)) for name, _ in ffi.typeof(structs).item.fields]
        for k in range(count)
    ]


def _number(value: float) -> float | str:
    """Return a number as JSON holds it: a string if JavaScript would round it or JSON forbids it."""
    if isinstance(value, int):
        return value if abs(value) < _WHOLE else str(value)
    if math.isfinite(value):
        return value
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
