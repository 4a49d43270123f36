"""Pack columns of integers and of bits as short text, which ``page/decode.js`` unpacks.

A robot drives straight most of the time, so the second differences of its poses are usually close
to 0 and take one byte each.
"""

from __future__ import annotations

import base64

import numpy as np
import numpy.typing as npt

_GROUPS = 9  # groups of seven bits: enough for any number below 2**62
_ONES = np.int64(127)
MOST = 2**50
"""Largest number that is packed; browsers still represent it exactly."""


def numbers(values: npt.ArrayLike) -> str:
    """Return integers as base64 of their second differences.

    Each difference is zigzag-encoded in groups of seven bits, the lowest first.

    Args:
        values: (n,) integers; they are clipped to ``MOST`` in both directions.
    """
    column = np.clip(np.asarray(values), -MOST, MOST).astype(np.int64)
    twice = np.diff(np.diff(column, prepend=np.int64(0)), prepend=np.int64(0))
    zigzag = (twice << np.int64(1)) ^ (twice >> np.int64(63))
    # Split into groups of seven bits; the eighth bit of each byte is set if another one follows.
    above = zigzag[:, None] >> np.arange(0, 7 * (_GROUPS + 1), 7, dtype=np.int64)
    used = above > 0
    used[:, 0] = True
    groups = (above[:, :-1] & _ONES) | (used[:, 1:].astype(np.int64) << np.int64(7))
    return _text(groups[used[:, :-1]].astype(np.uint8).tobytes())


def bits(flags: npt.ArrayLike) -> str:
    """Return bits as base64; the first is the lowest bit of the first byte."""
    return _text(np.packbits(np.asarray(flags, np.bool_).ravel(), bitorder="little").tobytes())


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
