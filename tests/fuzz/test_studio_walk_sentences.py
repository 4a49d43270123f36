"""The reader of docs/tutorials/studio-walk.md.

It performs every sentence of a step, and refuses those that it does not know.
"""

import pytest

from tests.helpers.studio_walk import NotUnderstood, Walker, sentences


def test_a_step_that_nobody_taught_is_not_passed_over():
    with pytest.raises(NotUnderstood, match="Have a look"):
        Walker(None).perform("Have a look around")


def test_every_sentence_of_a_step_counts_and_what_stands_between_does_not():
    text = "1. Press `a`. Click at 0.5,\n   0.5 m.\n\nA cup. 2. No step.\n\n12. Tick **b**.\n"
    assert sentences(text) == [(1, "Press `a`"), (1, "Click at 0.5, 0.5 m"), (12, "Tick **b**")]
