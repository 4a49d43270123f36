"""What holds for every registered format; each has tests of its own beside this."""

import re
from pathlib import Path

import pytest

from worldgen.cli.main import cli
from worldgen.interop import FORMATS

PAGE = (Path(__file__).parents[2] / "docs" / "formats.md").read_text()


@pytest.mark.parametrize("name", FORMATS.names())
def test_the_table_of_formats_has_a_row_with_way_and_command(name):
    known = FORMATS.get(name)
    row = re.search(rf"^\| `{name}` \| (\w+) \| (.+) \|(.*)\| (.+) \|$", PAGE, re.MULTILINE)
    assert row is not None and row[1] == known.direction and "worldgen " in row[4]


def test_the_page_names_every_option_of_export():
    options = [word for known in cli.get_command(None, "export").params for word in known.opts if word[:2] == "--"]
    assert [word for word in options if f"`{word}`" not in PAGE] == []
