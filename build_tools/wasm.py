"""Compile the C cores for pages: WebAssembly modules of the same sources, ``_core.wasm``.

A module lies next to the extension module of its core. It holds the functions that pages call
(``Core.in_pages``) and what these use, and imports nothing but the clock. The linker
drops processes, signals and Python, because pages call none of them.

A page must know where each field of a struct is, which depends on the size of a pointer. So the
compiler answers that: a generated C file puts sizes and offsets into the module, with the names
that cffi reads from the headers, and ``fuzz/player/page/live/core.js`` reads them there. There is
no second list that could be out of date.

``python -m build_tools.wasm`` compiles what has changed, in place. It takes the wheel ``ziglang``.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from build_tools.cores import CORES, FLAGS, ROOT, Core, compile_files, replace_module
from build_tools.targets import zig

if sys.platform != "win32":
    import fcntl

NAME = "_core.wasm"
"""File name of a module, in the folder of its package."""

_TARGET = ("-target", "wasm32-wasi")
# Position-independent code is for shared libraries. -Oz would save a seventh of the size, and takes
# twice the time to run.
_DROPPED = ("-fPIC", "-O3")
_FLAGS = (*(flag for flag in FLAGS if flag not in _DROPPED), "-O2", "-w")
_LINKED = ("-mexec-model=reactor", "-Wl,--gc-sections", "-Wl,--strip-all")
# Folders and files that no function for pages uses, or that need a whole system. If one of them
# becomes necessary, the linker says so.
_LEFT_OUT = frozenset(
    {
        *("joint", "making", "timed"),
        *("fleet", "edits.c", "lockstep.c", "navigate.c", "sensed.c"),
        *("guard.c", "python_act.c"),
    }
)
# Functions of the C library that pages call themselves.
_MEMORY = ("malloc", "calloc", "free")
# What the generated C file exports: the names, and the numbers that go with them.
_LAYOUT = ("wg_layout_names", "wg_layout_numbers")
_ENUM = re.compile(r"\benum\b\s*\w*\s*\{(.*?)\}", re.DOTALL)
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_CONSTANT = re.compile(r"\bWG_[A-Z0-9_]+\b")
_MAGIC_SIZE = 8


def compile_module(core: Core, made: Path, work: Path) -> None:
    """Compile one core for pages.

    Args:
        core: The core to compile.
        made: File of the module.
        work: Folder for object files; those whose sources are unchanged are reused.

    Raises:
        RuntimeError: If the wheel ``ziglang`` isn't installed.
        subprocess.CalledProcessError: If the compiler rejects something; it has printed the reason.
    """
    command = zig()
    if not command:
        raise RuntimeError("no compiler for WebAssembly found: `pip install ziglang`")
    work.mkdir(parents=True, exist_ok=True)
    layout = work / "layout.c"
    layout.write_text(layout_source(core), encoding="utf-8")
    line = [*command, "cc", *_TARGET, *_FLAGS]
    sources = [
        file for file in core.c_files() if _LEFT_OUT.isdisjoint(file.relative_to(ROOT).parts)
    ]
    objects = compile_files(core, [*sources, layout], line, work)

    exports = [f"-Wl,--export={name}" for name in (*core.in_pages, *_MEMORY, *_LAYOUT)]
    linked = work / f"linked-{NAME}"
    subprocess.run(
        [*command, "cc", *_TARGET, *_LINKED, *exports, *objects, "-o", str(linked)], check=True
    )
    linked.write_bytes(without_custom_sections(linked.read_bytes()))
    replace_module(linked, made)


def layout_source(core: Core) -> str:
    """Return the C file that puts sizes, offsets and constants into a module.

    Its names are lines: ``=WG_OK`` for a constant, ``WgDisc`` for the size of a struct, and
    ``WgDisc.reach int64_t`` for the offset of a field with its type. A field that is a struct is
    followed by that struct's fields. Each line has one number.
    """
    from cffi import FFI  # noqa: PLC0415 - only the build needs it

    ffi = FFI()
    ffi.cdef(core.declarations())
    names = []
    numbers = []
    for body in _ENUM.findall(_COMMENT.sub("", core.declarations())):
        for part in body.split(","):
            constant = _CONSTANT.search(part)
            if constant is not None:
                names.append(f"={constant[0]}")
                numbers.append(constant[0])
    for struct in _structs(ffi, core):
        names.append(struct.cname)
        numbers.append(f"sizeof({struct.cname})")
        for path, kind in _fields(struct, ""):
            names.append(f"{struct.cname}.{path} {kind}")
            numbers.append(f"offsetof({struct.cname}, {path})")
    lines = "".join(f'    "{name}\\n"\n' for name in names)
    values = "".join(f"    {number},\n" for number in numbers)
    return (
        f"#include <stddef.h>\n{core.preamble()}\n"
        f"const char {_LAYOUT[0]}[] =\n{lines};\n\n"
        f"const int32_t {_LAYOUT[1]}[] = {{\n{values}}};\n"
    )


def _structs(ffi: Any, core: Core) -> list[Any]:
    """Return the structs that a core's functions for pages take, and those that these lead to."""
    text = _COMMENT.sub("", core.declarations())
    named = {
        name
        for function in core.in_pages
        for declared in re.findall(rf"\b{function}\(.*?;", text, re.DOTALL)
        for name in re.findall(r"\bWg\w+\b", declared)
    }
    waiting = [ffi.typeof(name) for name in sorted(named)]
    found: dict[str, Any] = {}
    while waiting:
        kind = waiting.pop(0)
        while kind.kind in ("pointer", "array"):
            kind = kind.item
        if kind.kind == "struct" and kind.fields and kind.cname not in found:
            found[kind.cname] = kind
            waiting += [field.type for _, field in kind.fields]
    return list(found.values())


def _fields(struct: Any, prefix: str) -> list[tuple[str, str]]:
    """Return the path and the type of each field, and of the fields of structs in it."""
    found = []
    for name, field in struct.fields:
        path = f"{prefix}{name}"
        kind = field.type
        if kind.kind == "struct":
            found += _fields(kind, f"{path}.")
        else:
            found.append((path, _kind(kind)))
    return found


def _kind(kind: Any) -> str:
    """Return how a page reads and writes a field: by a type's name, of the first item of an array."""
    if kind.kind == "array":
        return _kind(kind.item)
    if kind.kind in ("pointer", "function"):
        return "pointer"
    return "int32_t" if kind.kind == "enum" else str(kind.cname)


def without_custom_sections(module: bytes) -> bytes:
    """Return a WebAssembly module without names and notes of its compiler, which nobody runs."""
    kept = bytearray(module[:_MAGIC_SIZE])
    at = _MAGIC_SIZE
    while at < len(module):
        size, begin = _number(module, at + 1)
        if module[at] != 0:
            kept += module[at : begin + size]
        at = begin + size
    return bytes(kept)


def _number(module: bytes, at: int) -> tuple[int, int]:
    """Return a number in LEB128, and where it ends."""
    value = shift = 0
    while True:
        byte = module[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at


def module_of(core: Core) -> Path:
    """Return where the module of a core belongs."""
    return ROOT / core.module.partition(".")[0] / NAME


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait until no other process compiles into a folder: several reports may begin at once."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        # Windows has no such locks; there, two processes do the same work twice.
        if sys.platform != "win32":
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def main() -> None:
    """Compile the modules in place."""
    work = ROOT / "build" / "wasm"
    with _alone(work):
        for core in CORES:
            if core.in_pages:
                compile_module(core, module_of(core), work / core.module)
                print(module_of(core).relative_to(ROOT))  # noqa: T201 - a script of developers


if __name__ == "__main__":
    main()
