"""The studio's documentation matches its page."""

import re
from importlib.resources import files
from pathlib import Path

from build_tools import page_types
from fuzz.studio.answers import answer
from fuzz.studio.requests.protocol import REQUESTS, Cancel, Edits, Stop, Watch
from tests.helpers.command_line import worldgen

DOCS = Path(__file__).parents[2] / "docs"


def test_the_pages_types_are_those_of_the_messages():
    assert page_types.FILE.read_text() == page_types.page_types()


def test_every_request_that_a_process_answers_has_a_function():
    answered = {kind for kind in REQUESTS.values() if kind in answer.registry}
    assert {*REQUESTS.values()} - answered == {Edits, Watch, Stop, Cancel}


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
    script = (files("fuzz.player") / "page" / "edit" / "tools.js").read_text()
    keys = re.findall(r'^  \w+: \[\s*"[^"]+",\s*"(\w)",\s*"M', script, re.MULTILINE)
    assert len(keys) == 12 and all(f"`{key}`" in text for key in keys)


def test_the_pictures_are_there():
    pages = ("howto/studio.md", "tutorials/studio-walk.md")
    text = "".join((DOCS / page).read_text() for page in pages)
    pictures = set(re.findall(r"\]\(\.\./(pictures/[^)]+)\)", text))
    assert len(pictures) >= 6 and all((DOCS / picture).exists() for picture in pictures)
