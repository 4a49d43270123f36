"""The studio's documentation matches its page."""

import re
from importlib.resources import files
from pathlib import Path

from fuzz.studio.workers import WORKER_OF
from tests.helpers.command_line import worldgen

DOCS = Path(__file__).parents[2] / "docs"


def test_every_question_of_the_protocol_is_described():
    rows = set(
        re.findall(
            r"^\| `(\w+)` \|",
            (DOCS.parent / "fuzz" / "studio" / "protocol.md").read_text(),
            re.MULTILINE,
        )
    )
    assert rows - {"do"} == {*WORKER_OF, "cancel"}


def test_every_option_of_the_command_is_described():
    options = set(re.findall(r"--[a-z-]+", worldgen("studio", "--help").out)) - {
        "--help",
        "--browser",
        "--trust",  # every command has it; SECURITY.md describes it
    }
    text = (DOCS / "howto" / "studio.md").read_text()
    assert all(option in text for option in options)


def test_every_tool_is_described_with_its_key():
    text = (DOCS / "howto" / "studio.md").read_text()
    script = (files("fuzz.studio") / "page" / "draw" / "tools.js").read_text()
    keys = re.findall(r'^  \w+: \[\s*"[^"]+",\s*"(\w)",\s*"M', script, re.MULTILINE)
    assert len(keys) == 11 and all(f"`{key}`" in text for key in keys)


def test_the_pictures_are_there():
    text = (DOCS / "howto" / "studio.md").read_text()
    pictures = set(re.findall(r"\]\(\.\./(pictures/[^)]+)\)", text))
    assert len(pictures) >= 6 and all((DOCS / picture).exists() for picture in pictures)
