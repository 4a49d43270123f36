"""The oracles in docs/reference/verdicts.md; the nightly tier runs its commands (test_documented_commands)."""

import re

from fuzz.oracles import ORACLES, NamedOracle
from fuzz.shrink import shrink
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.scenario import Scenario
from tests.repo.documented_commands import DOCS, part_with
from worldgen import generate

PAGE = part_with(DOCS / "reference" / "verdicts.md", "Oracles")
[CODE] = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_its_own_oracle_has_ten_lines():
    assert len(CODE.splitlines()) <= 10


def test_a_failure_of_its_own_oracle_names_it_and_its_objection_and_is_one_minimal(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clumsy.py").write_text(CODE)
    oracle = NamedOracle.parse("./clumsy.py:clumsy=3")
    failure = shrink(failure_of(generate("trap", 1, size=12), Scenario("bug2"), oracle)).failure
    record = failure.record
    assert record.evidence["oracle"] == "./clumsy.py:clumsy=3"
    assert record.evidence["objection"]["touches"] > 3
    assert record.verdict == "reached" and record.details["one_minimal"]
    assert record.details["class"] == "clumsy" and record.details["cause"] == "breaks-a-rule"
    assert replay(failure).confirmed


def test_the_page_names_every_oracle():
    names = re.findall(r"^\| `([a-z]+)(?:=[A-Z]+)?` \|", PAGE.partition("\n### ")[0], re.MULTILINE)
    assert sorted(names) == ORACLES.names()
