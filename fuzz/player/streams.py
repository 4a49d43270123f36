"""Columns of whole numbers and of bits as short text, which ``page/decode.js`` reads back.

A robot drives straight most of the time, so the second differences of its poses are mostly 0 or
    near it: a byte each.
"""

from __future__ import annotations

import base64

import numpy as np
import numpy.typing as npt

__all__ = ["bits", "numbers"]

_GROUPS = 9  # of seven bits: any number below 2**62
_ONES = np.int64(127)
_MOST = 2**50


def numbers(values: npt.ArrayLike) -> str:
    """Whole numbers as base64 of their second differences, each zigzag and in groups of seven bits, the lowest first.

    Args:
        values: (n,) whole numbers; what is beyond 2**50 either way becomes that, which a browser
            still counts exactly.
    """
    column = np.clip(np.asarray(values), -_MOST, _MOST).astype(np.int64)
    twice = np.diff(np.diff(column, prepend=np.int64(0)), prepend=np.int64(0))
    zigzag = (twice << np.int64(1)) ^ (twice >> np.int64(63))
    above = zigzag[:, None] >> np.arange(0, 7 * (_GROUPS + 1), 7, dtype=np.int64)
    used = above > 0
    used[:, 0] = True
    groups = (above[:, :-1] & _ONES) | (used[:, 1:].astype(np.int64) << np.int64(7))
    return _text(groups[used[:, :-1]].astype(np.uint8).tobytes())


def bits(flags: npt.ArrayLike) -> str:
    """Bits as base64, the first in the lowest bit of the first byte."""
    return _text(np.packbits(np.asarray(flags, np.bool_).ravel(), bitorder="little").tobytes())


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
