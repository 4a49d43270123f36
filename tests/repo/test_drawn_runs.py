"""The pictures of runs in the pages say what the program says today."""

import re
from pathlib import Path

import pytest
from PIL import Image

from docs.draw_runs import RUNS, draw

DOCS = Path(__file__).parents[2] / "docs"
AGAIN = "run python -m docs.draw_runs, and look at what it draws"

# Drawn by other scripts, which have tests of their own, or from what others' programs recorded.
FROM_ELSEWHERE = re.compile(
    r"(gallery|compose|difficulty|fire|library|report|studio|census|thesis|audit|nav2|watchdogs)\b"
)


def words(picture):
    with Image.open(picture) as image:
        return image.info.get("Description")


@pytest.mark.nightly
def test_the_words_in_each_picture_of_a_run_are_those_of_today(tmp_path):
    stale = [
        drawn.name
        for drawn in draw(tmp_path)
        if words(drawn) != words(DOCS / "pictures" / drawn.name)
    ]
    assert stale == [], AGAIN


def test_a_picture_that_no_script_draws_is_noticed():
    drawn = {f"{name}.png" for name in RUNS}
    others = {file.name for file in (DOCS / "pictures").iterdir()} - drawn
    assert [name for name in sorted(others) if not FROM_ELSEWHERE.match(name)] == []
