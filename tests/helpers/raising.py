"""What an error must say, as data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from worldgen.errors import WorldgenError

__all__ = ["raises"]


@contextmanager
def raises(kind: type[WorldgenError], code: str, /, **facts: Any) -> Iterator[pytest.ExceptionInfo[Any]]:
    """Expect an error of a class, with a code and some of its facts.

    Args:
        kind: Its class, or one above it.
        code: The rule that was broken.
        facts: Those of its facts that the test is about; the others are not looked at.

    Yields:
        What ``pytest.raises`` gives: ``.value`` is the error, once the block has ended.
    """
    with pytest.raises(kind) as caught:
        yield caught
    error = caught.value
    assert error.code == code, f"{error.code} came: {error}"
    assert {name: error.facts.get(name) for name in facts} == facts, str(error)
