"""The walk through the studio, performed as docs/tutorials/studio-walk.md describes it."""

from pathlib import Path

import pytest

from tests.helpers.studio_page import opened_at
from tests.helpers.studio_walk import Walker, answered, begun, commands, fits, sentences

pytestmark = pytest.mark.gate

WALK = (Path(__file__).parents[2] / "docs/tutorials/studio-walk.md").read_text(encoding="utf-8")


@pytest.mark.nightly
def test_the_walk_goes_as_it_is_written(browser, tmp_path):
    (make, nothing), (studio, _), (line, says) = commands(WALK)
    assert answered(make, tmp_path) == nothing
    allowed = ["clipboard-read", "clipboard-write"]
    with (
        begun(studio, tmp_path) as address,
        opened_at(browser, address, permissions=allowed) as page,
    ):
        walker = Walker(page)
        for _, sentence in sentences(WALK):
            walker.perform(sentence)
        copied = page.evaluate("navigator.clipboard.readText()")
        assert page.complaints == []
    assert fits(line, copied)
    said = answered(copied, tmp_path)
    assert len(said) == len(says) and all(map(fits, says, said)), said
