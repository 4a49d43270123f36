"""What docs/explanation/search.md shows can be run as it stands."""

import re
from pathlib import Path

DOCUMENT = Path(__file__).parents[2] / "docs" / "explanation" / "search.md"


def test_the_example_runs_and_finds_the_longest_way_round(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    names = {}
    exec(example, names)
    assert "'loop'" in capsys.readouterr().out
    looks = names["looks"]
    assert looks.verdict[names["worst"]] == "reached"
