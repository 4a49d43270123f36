"""The commands in docs/reference/verdicts.md work, with its oracle of ten lines."""

import re
import shlex

import pytest

from fuzz.oracles import ORACLES
from tests.helpers.command_line import worldgen
from tests.repo.documented_commands import DOCS, part_with
from worldgen import read_world

PAGE = part_with(DOCS / "reference" / "verdicts.md", "Oracles")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The page's commands, one after another, in a folder with its oracle: command, result."""
    folder = tmp_path_factory.mktemp("page")
    [code] = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    (folder / "clumsy.py").write_text(code)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        lines = re.findall(r"^\$ worldgen (.*)$", PAGE, re.MULTILINE)
        yield folder, [(line, worldgen(*shlex.split(line), *few(line))) for line in lines]


def few(line):
    return ("--examples", "40", "--workers", "1") if line.startswith("fuzz") else ()


@pytest.mark.gate
def test_its_campaigns_find_failures_that_replay(done):
    codes = [(line.split()[0], result.code) for line, result in done[1]]
    assert codes == [("fuzz", 1), ("replay", 0)] * 2


@pytest.mark.gate
def test_its_own_oracle_finds_a_class_of_its_own(done):
    record = read_world(done[0] / "clumsy" / "clumsy.grid").failure
    assert (
        record.evidence["oracle"] == "./clumsy.py:clumsy=3"
        and record.evidence["objection"]["touches"] > 3
    )
    assert record.verdict == "reached" and record.details["one_minimal"]


def test_its_own_oracle_has_ten_lines():
    [code] = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(code.splitlines()) <= 10


@pytest.mark.gate
def test_a_failure_by_an_oracle_says_what_was_found(done):
    out = done[1][0][1].out
    assert "breaks-a-rule" in out


def test_the_page_names_every_oracle():
    names = re.findall(r"^\| `([a-z]+)(?:=[A-Z]+)?` \|", PAGE.partition("\n### ")[0], re.MULTILINE)
    assert sorted(names) == ORACLES.names()
