"""The gallery shows every family with all its choices, and its commands make the worlds in its
pictures.
"""

import importlib.util
import re
import shlex
import sys
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen
from worldgen.family import FAMILIES
from worldgen.sets import manifest_of

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reference" / "families.md").read_text(encoding="utf-8")
AGAIN = "run python docs/draw_gallery.py, and look at what it draws"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("draw_gallery", DOCS / "draw_gallery.py")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(
        spec
    )  # dataclasses look the module up there
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("family", FAMILIES.names())
def test_every_word_of_every_family_is_shown(script, family):
    assert f"pictures/gallery-{family}.png" in PAGE
    shown = [{**FAMILIES.get(family).defaults(), **kind.params} for kind in script.GALLERY[family]]
    for parameter in FAMILIES.get(family).parameters:
        assert set(parameter.choices) <= {params[parameter.name] for params in shown}


def test_the_page_says_how_to_make_the_sets(script):
    assert f"`{shlex.join(script.SETS)}`" in PAGE


@pytest.mark.gate
@pytest.mark.parametrize("family", FAMILIES.names())
def test_the_commands_make_the_worlds_of_the_picture(script, family, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = []
    for command, ids in re.findall(
        rf"^\| {family}, [^|]*\| `worldgen (.*?)` \| ([0-9a-f ]+) \|$",
        script.section(),
        re.MULTILINE,
    ):
        assert worldgen(*shlex.split(command), *script.SETS, "--no-metrics", "--force").code == 0
        digests = [entry.digest[: script.ID] for entry in manifest_of(tmp_path / "worlds").entries]
        assert digests == ids.split(), AGAIN
        made += digests
    assert made == script.shown(family) and len(made) == script.EACH * len(
        script.GALLERY[family]
    ), AGAIN


def test_the_pictures_are_small(script):
    assert sum(script.picture_of(family).stat().st_size for family in script.GALLERY) < 1_500_000
