"""The example of a trained policy arrives as its README states, and its failures replay."""

import re
import shutil
from pathlib import Path

import pytest

from sim import simulate_many
from tests.helpers.command_line import worldgen
from worldgen import generate

EXAMPLE = Path(__file__).parents[2] / "examples" / "train"


@pytest.fixture
def project(tmp_path, monkeypatch):
    shutil.copytree(EXAMPLE, tmp_path / "train", ignore=shutil.ignore_patterns("__pycache__", ".*"))
    monkeypatch.chdir(tmp_path / "train")


def test_what_traps_the_policy_replays_as_the_guide_shows(project):
    shown = re.search(
        r"\$ worldgen replay failures/\n(.*?)```", (EXAMPLE / "README.md").read_text(), re.DOTALL
    )
    result = worldgen("replay", "--trust", "failures/")
    assert (result.code, result.out) == (0, shown.group(1))


@pytest.mark.gate
def test_the_policy_arrives_in_most_worlds_that_it_was_not_trained_in(project):
    worlds = [generate("trap", seed=1_000_000 + k, size=20) for k in range(30)]
    runs = simulate_many(worlds, "./policy.py:Policy", steps=1000)
    assert runs.reached.sum() >= 25


def test_the_guide_names_every_file():
    guide = (EXAMPLE / "README.md").read_text()
    assert all(
        f"`{path.name}" in guide for path in EXAMPLE.iterdir() if path.suffix in (".py", ".npz")
    )
