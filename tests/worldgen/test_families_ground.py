"""The ground of a world that changes: any family, with its own parameters."""

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.fire import fire
from worldgen.family import FAMILIES, family
from worldgen.generation import generate
from worldgen.reach import check_certificate
from worldgen.timeline import Event, Timeline
from worldgen.world import Pose, Target, World

PLUGIN = """
import numpy as np
from worldgen.family import family
from worldgen.world import Pose, Target, World


@family("pillars", version=1)
def pillars(rng, *, width: int = 24, pillars: int = 20, closed: bool = False) -> World:
    walls = np.zeros((20, width), dtype=bool)
    walls[-1] = closed
    for _ in range(pillars):
        walls[rng.between(4, 16), rng.between(4, width - 4)] = True
    return World(walls, start=Pose(0.2, 0.2), target=Target(width / 10 - 0.2, 1.73, 0.05), robot_radius=0.08)
"""


@pytest.fixture
def plugin(tmp_path):
    path = tmp_path / "a+b" / "mine.py"
    path.parent.mkdir()
    path.write_text(PLUGIN)
    return f"{path}:pillars"


@pytest.mark.parametrize("name", ["fire", "shift"])
@pytest.mark.parametrize(
    ("over", "same"),
    [
        ("maze+algorithm=eller+passage=3", {"algorithm": "eller", "passage": 3}),
        ("rooms+plan=suite+closed=0.5", {"plan": "suite", "closed": 0.5}),
        ("trap+shape=L+inside", {"shape": "L", "inside": True}),
    ],
)
def test_a_grounds_own_parameters_can_be_set(name, over, same, monkeypatch):
    below = FAMILIES.get(over.partition("+")[0])
    asked = []

    def build(rng, **params):
        asked.append(params)
        return below.build(rng, **params)

    monkeypatch.setitem(FAMILIES._loaded, below.name, _Spy(below, build))
    generate(name, 4, over=over)
    assert all(params.items() >= same.items() for params in asked) and asked


class _Spy:
    """A family that records its calls."""

    def __init__(self, below, build):
        self._below, self.build = below, build

    def __getattr__(self, name):
        return getattr(self._below, name)


def test_a_ground_from_a_file_burns_though_it_is_no_square_and_has_no_border(plugin):
    for seed in range(5):
        world = generate("fire", seed, over=f"{plugin}+width=40+pillars=60+closed", margin=1.0)
        assert world.walls.shape == (20, 40) and world.robot_radius == 0.08 and world.is_dynamic
        assert check_certificate(world).valid


def test_a_ground_that_is_no_square_cannot_be_mirrored(plugin):
    with raises(InvalidParameter, "not-square", width=40, height=20):
        generate("shift", 1, over=f"{plugin}+width=40")


@pytest.mark.parametrize(
    ("over", "expected"),
    [
        ("", {"code": "empty-name"}),
        ("fire", {"code": "world-changes", "over": "fire", "family": "fire"}),
        ("shift+over=maze", {"code": "world-changes", "family": "shift"}),
        ("mase", {"code": "unknown-name", "name": "mase", "noun": "family", "near": "maze"}),
        ("maze+size=40", {"code": "not-of-the-ground", "name": "size", "over": "maze+size=40"}),
        ("maze+robot-radius=0.1", {"code": "not-of-the-ground", "name": "robot_radius"}),
        (
            "maze+passages=3",
            {"code": "unknown-name", "name": "passages", "owner": "over=maze+passages=3: maze"},
        ),
        (
            "maze+passage=wide",
            {"code": "not-a-number", "name": "passage", "text": "wide", "expected": "whole number"},
        ),
        ("maze+passage", {"code": "missing-value", "name": "passage"}),
        ("trap+inside=maybe", {"code": "not-a-truth-value", "name": "inside", "text": "maybe"}),
        ("maze+algorithm=ellen", {"code": "unknown-name", "name": "algorithm", "value": "ellen"}),
        ("maze+braid=2", {"code": "out-of-range", "name": "braid"}),
        ("rooms+door=nan", {"code": "not-a-number", "name": "door", "expected": "whole number"}),
    ],
)
def test_a_wrong_ground_is_refused(over, expected):
    with raises(InvalidParameter, **expected):
        generate("fire", 1, over=over)


def test_a_ground_that_changes_without_saying_so_is_refused(monkeypatch):
    @family("restless", version=1)
    def restless(rng, *, size: int = 12) -> World:
        return World(np.zeros((size, size), bool), Pose(0.3, 0.3), Target(0.8, 0.8, 0.05),
                     timeline=Timeline.of([Event(1.0, 5, 5, 1)]))  # fmt: skip

    monkeypatch.setitem(FAMILIES._loaded, "restless", restless)
    monkeypatch.setattr(type(FAMILIES), "get", lambda self, name: self._loaded[name])
    with raises(InvalidParameter, "world-changes"):
        generate(fire, 1, over="restless")


def test_a_margin_that_is_no_float_is_told():
    with raises(InvalidParameter, "reserved-name", name="own", parameter="margin"):
        family("own", version=1)(lambda rng, *, margin=1: None)
