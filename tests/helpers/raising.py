"""Check the contents of an error, as data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from worldgen.errors import WorldgenError


@contextmanager
def raises(
    kind: type[WorldgenError], /, code: str, **facts: Any
) -> Iterator[pytest.ExceptionInfo[Any]]:
    """Expect an error of a class, with a code and some of its facts.

    Args:
        kind: Its class, or a base class.
        code: The rule that was broken.
        facts: The facts that the test is about; others are ignored.

    Yields:
        What ``pytest.raises`` gives: ``.value`` is the error, once the block has ended.
    """
    with pytest.raises(kind) as caught:
        yield caught
    check_says(caught.value, code, **facts)


def check_says(error: WorldgenError, /, code: str, **facts: Any) -> None:
    """Fail the test if an error has a different code, or a different value for one of these facts.

    ``line`` is a file's.
    """
    assert error.code == code, f"{error.code} came: {error}"
    known = {"line": getattr(error, "line", None), **error.facts}
    assert {name: known.get(name) for name in facts} == facts, str(error)
