"""The reference lists what the shrinker does, and docs/howto/shrink.md shows commands that work."""

import re

import pytest

from fuzz.facts.proofs import certified
from fuzz.shrink import ORDER, PASSES
from fuzz.triage.judging import failure_of
from sim.scenario import Scenario
from tests.fuzz.test_shrink import cup_world
from tests.helpers.command_line import worldgen
from tests.repo.documented_commands import DOCS

REFERENCE = (DOCS / "reference" / "campaign-files.md").read_text(encoding="utf-8")
PAGE = (DOCS / "howto" / "shrink.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("title", "listed"), [("What simpler means", ORDER), ("Passes", PASSES)])
def test_the_page_lists_what_the_shrinker_has_in_the_same_order(title, listed):
    rows = re.findall(
        r"^\| `([a-z-]+)` \| (.*) \|$",
        REFERENCE.partition(f"### {title}\n")[2].partition("\n### ")[0],
        re.M,
    )
    assert rows == [(one.name, one.says) for one in listed]


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
