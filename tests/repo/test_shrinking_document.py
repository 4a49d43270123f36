"""docs/howto/shrink.md shows commands that work."""

import re

import pytest

from fuzz.facts.proofs import certified
from fuzz.triage.judging import failure_of
from sim.scenario import Scenario
from tests.fuzz.test_shrink import cup_world
from tests.helpers.command_line import worldgen
from tests.repo.documented_commands import DOCS

PAGE = (DOCS / "howto" / "shrink.md").read_text(encoding="utf-8")


@pytest.mark.gate
@pytest.mark.parametrize(
    "line", re.findall(r"^\$ worldgen (shrink.*?)(?: *#.*| > .*)?$", PAGE, re.M)
)
def test_a_command_of_the_page_works(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failure_of(certified(cup_world()), Scenario("turn-right"), fewest_steps=20_000).write(
        tmp_path / "big.grid"
    )
    result = worldgen(*line.split())
    assert result.code == 0, result.err
