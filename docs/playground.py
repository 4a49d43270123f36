"""Write the playground: worlds that a reader changes in the browser, without an installation.

It is the editor of reports on worlds that are made here, in one static file: the cores judge each
change in the page. The site shows it as a page of its own, and instead of some pictures as a figure
of which everything can be dragged (``docs/conf.py``).

``python -m docs.playground FILE`` writes the page alone.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzz.player import drawn_world, sensors_of
from fuzz.player.live import live_question
from fuzz.player.one_file import modules, one_file
from sim.controllers.catalogue import CONTROLLERS
from sim.scenario import Scenario
from worldgen.families import trap
from worldgen.files.grid import dumps
from worldgen.generation import generate
from worldgen.interop import import_world
from worldgen.world import World

HERE = Path(__file__).parent
NAME = "playground.html"
CONTROLLERS_HERE = (
    "turn-right",
    "turn-left",
    "bug1",
    "bug2",
    "tangent-bug",
    "wall-left",
    "potential-field",
    "vfh",
)


class Scene(NamedTuple):
    """Worlds of one kind.

    Args:
        name: Its name in addresses.
        title: Its name for readers.
        controller: The controller that runs at first; empty for the proof alone.
        worlds: The worlds by the value of their parameter, in its order.
        parameter: The name of that parameter; empty for one world.
    """

    name: str
    title: str
    controller: str
    worlds: dict[str, World]
    parameter: str = ""


# The family's parameter that changes its worlds most, with values for a slider.
SLIDERS: dict[str, tuple[str, tuple[float, ...]]] = {
    "corridor": ("width", (2, 3, 4, 5, 6)),
    "trap": ("depth", (4, 6, 8, 10, 12, 14)),
    "maze": ("braid", (0.0, 0.25, 0.5, 0.75, 1.0)),
    "rooms": ("door", (2, 3, 4, 5)),
    "cave": ("rock", (36, 40, 44, 48, 52)),
    "forest": ("density", (0.2, 0.4, 0.6, 0.8, 1.0)),
    "rubble": ("debris", (0.0, 0.15, 0.35, 0.5, 0.65)),
}
_SIZE = 24
_SEED = 3

# Pictures of the pages whose place a figure takes on the site, by the scene.
FIGURES = {"loop": "loop", "reach-witness": "path", "reach-cut": "walled"}
# Pictures that a figure follows.
FOLLOWED = {f"gallery-{family}": family for family in SLIDERS}


def scenes() -> Iterator[Scene]:
    """Yield all scenes; the README's loop is the first."""
    loop = trap(seed=_SEED, size=_SIZE)
    yield Scene("loop", "the README's loop", "turn-right", {"": loop})
    yield Scene("path", "a path around a trap", "", {"": loop})
    walled = import_world(HERE / "playground" / "walled.txt").world
    yield Scene("walled", "a room with a narrow opening", "", {"": walled})
    for family, (parameter, values) in SLIDERS.items():
        worlds = {
            f"{value:g}": generate(family, _SEED, size=_SIZE, **{parameter: value})
            for value in values
        }
        yield Scene(family, family, "bug2", worlds, parameter)


def page() -> bytes:
    """Return the page."""
    runs: list[dict[str, Any]] = []
    places: dict[tuple[float, ...], int] = {}
    sensors: dict[str, Any] = {}
    packed_scenes = []
    for scene in scenes():
        worlds = []
        for value, world in scene.worlds.items():
            # Edits of walls, ends and radius leave the recipe of a run as it is; so do other worlds.
            kind = (*world.walls.shape, world.cell_size, world.robot_speed)
            if kind not in places:
                places[kind] = len(runs)
                runs.append(_recipes(world, sensors))
            bare = world.bare
            worlds.append(
                {
                    "value": value,
                    "question": live_question(bare, None, None)["world"],
                    "source": dumps(replace(bare, provenance=None)).decode("utf-8"),
                    "drawn": drawn_world(bare),
                    "kind": places[kind],
                }
            )
        packed_scenes.append(
            {
                "name": scene.name,
                "title": scene.title,
                "controller": scene.controller,
                "parameter": scene.parameter,
                "worlds": worlds,
            }
        )
    contents = {
        "scenes": packed_scenes,
        "runs": runs,
        "sensors": sensors,
        "controllers": CONTROLLERS_HERE,
    }
    text = json.dumps(contents, separators=(",", ":")).encode("utf-8")
    packed = base64.b64encode(gzip.compress(text, mtime=0)).decode("ascii")
    own = HERE / "playground"
    report = files("fuzz.report") / "page"
    return one_file(
        (own / "body.html").read_text("utf-8"),
        "worldgen playground",
        styles=(report / "style.css").read_text("utf-8") + (own / "style.css").read_text("utf-8"),
        scripts=modules(report, "#report/") | modules(own, "#playground/"),
        start="#playground/start.js",
        data={"packed": packed},
        live=True,
    )


def _recipes(world: World, sensors: dict[str, Any]) -> dict[str, Any]:
    """Return how a page runs each controller in worlds like this one."""
    # The page edits the walls, so they may be anywhere, even at the start.
    empty = replace(world.bare, walls=np.zeros_like(world.walls))
    found = {}
    for name in CONTROLLERS_HERE:
        controller = CONTROLLERS.get(name)
        options = Scenario.parse(name).options(empty)
        found[name] = live_question(empty, controller, options)["run"]
        sensors.setdefault(name, sensors_of(controller, options, world.cell_size))
    return found


def frame(scene: str, title: str, root: str) -> str:
    """Return the HTML of a figure.

    Args:
        scene: The scene's name.
        title: What a screen reader calls it.
        root: Address of the site's first folder, relative to the page.
    """
    return (
        f'<iframe class="live" src="{root}{NAME}?{scene}" title="{html.escape(title)}" '
        'loading="lazy" style="width: 100%; height: 30rem; border: 0"></iframe>'
    )


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(page())
