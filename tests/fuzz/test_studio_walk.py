"""The walk through the studio, performed as docs/studio-walk.md says it."""

from pathlib import Path

import pytest

from tests.helpers.browser import missing_browser

pytest.importorskip("playwright", reason="no playwright here: the studio is not tested in a browser")
pytestmark = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

from tests.helpers.studio_page import opened_at  # noqa: E402
from tests.helpers.studio_walk import NotUnderstood, Walker, answered, begun, commands, fits, sentences  # noqa: E402

WALK = (Path(__file__).parents[2] / "docs/studio-walk.md").read_text(encoding="utf-8")


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


def test_a_step_that_nobody_taught_is_not_passed_over():
    with pytest.raises(NotUnderstood, match="Have a look"):
        Walker(None).perform("Have a look around")


def test_every_sentence_of_a_step_counts_and_what_stands_between_does_not():
    text = "1. Press `a`. Click at 0.5,\n   0.5 m.\n\nA cup. 2. No step.\n\n12. Tick **b**.\n"
    assert sentences(text) == [(1, "Press `a`"), (1, "Click at 0.5, 0.5 m"), (12, "Tick **b**")]
