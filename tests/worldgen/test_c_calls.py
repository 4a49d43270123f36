"""What C keeps the address of lives until C is done with it."""

import gc
from pathlib import Path

from worldgen._core import ffi
from worldgen.support.ccall import kept

ROOT = Path(__file__).parents[2]


def test_what_c_points_to_is_released_after_it_is_freed():
    order = []

    class Array:
        def __del__(self):
            order.append("released")

    handle = kept(ffi, ffi.new("int64_t *"), Array(), free=lambda _: order.append("freed"))
    gc.collect()
    assert not order
    del handle
    assert order == ["freed", "released"]


def test_addresses_are_owned_in_one_way_only():
    packages = ("worldgen", "sim", "fuzz", "worldgen_plugins")
    files = (file for package in packages for file in (ROOT / package).rglob("*.py"))
    users = [file.name for file in files if "ffi.gc(" in file.read_text(encoding="utf-8")]
    assert users == ["ccall.py"]
