"""The oracles in docs/reference/verdicts.md; the nightly tier runs its commands (test_documented_commands)."""

import re

from fuzz.oracles import ORACLES
from tests.repo.documented_commands import DOCS, part_with

PAGE = part_with(DOCS / "reference" / "verdicts.md", "Oracles")


def test_its_own_oracle_has_ten_lines():
    [code] = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(code.splitlines()) <= 10


def test_the_page_names_every_oracle():
    names = re.findall(r"^\| `([a-z]+)(?:=[A-Z]+)?` \|", PAGE.partition("\n### ")[0], re.MULTILINE)
    assert sorted(names) == ORACLES.names()
