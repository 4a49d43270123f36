"""The examples in docs/explanation/search.md run as they are."""

import re

from tests.repo.documented_commands import DOCS, part_with

DOCUMENT = part_with(DOCS / "explanation" / "search.md", "The native strategy")


def test_the_example_runs_and_finds_the_longest_way_round(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
    names = {}
    exec(example, names)
    assert "'loop'" in capsys.readouterr().out
    looks = names["looks"]
    assert looks.verdict[names["worst"]] == "reached"
