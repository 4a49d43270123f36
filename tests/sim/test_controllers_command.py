"""``worldgen controllers``: every controller with what it does, and what it senses."""

import json

import pytest

from sim.controllers import CONTROLLERS
from tests.helpers.command_line import worldgen

MINE = """
class Mine:
    \"\"\"Stand still and look around.

    It never arrives.
    \"\"\"

    def reset(self):
        return ()

    def act(self, observation, memory):
        return (0.0, 0.1), memory
"""


def listed(*args):
    return json.loads(worldgen("controllers", *args, "--json").out)["controllers"]


@pytest.mark.parametrize("row", listed(), ids=lambda row: row["name"])
def test_each_controller_says_in_a_line_what_it_does_and_senses(row):
    assert row["about"].endswith(".") and len(row["about"]) <= 80 and row["in_words"]


def test_the_table_has_a_line_for_each_controller():
    head, *lines = worldgen("controllers").out.splitlines()
    assert head.split()[:2] == ["controller", "senses"]
    assert [line.split()[0] for line in lines] == CONTROLLERS.names()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("random-walk", "touch, chance"),
        ("vfh", "target, compass, 72 beams"),
        ("pibt", "the map, position, compass, other robots"),
        ("odometry-bug", "touch, target, wheels"),
        ("behaviours:avoid,wander", "touch, compass, chance"),
    ],
)
def test_the_senses_are_those_that_the_controller_declares(name, words):
    assert listed(name)[0]["in_words"] == words


def test_a_controller_that_needs_beams_says_how_many():
    (row,) = listed("tangent-bug")
    assert "beams" in row["senses"] and row["needs"] == {"beams": 72, "beam_range": 1.0}


def test_a_users_own_class_says_the_first_line_of_its_docstring(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    (row,) = listed(f"{tmp_path}/mine.py:Mine")
    assert row["about"] == "Stand still and look around."
    assert row["in_words"] == "everything but the clock"


def test_an_unknown_controller_is_one_plain_error():
    result = worldgen("controllers", "bug3")
    assert (result.code, result.error_code) == (2, "unknown-name")
