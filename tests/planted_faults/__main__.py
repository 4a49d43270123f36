"""``python -m tests.planted_faults [NAME ...]``.

Plant faults one by one and report which tier of tests catches each. The sources are copied once;
each fault is put into the copy, the tests run there until one fails, and the fault is removed
again; for a fault in C, the cores are compiled each time. The files that the table expects to catch
it run first; only if they all pass does the whole tier run, and then the next one. The table goes
to standard output as Markdown. ``--copy FOLDER`` uses an existing copy, so that its compiled cores
are reused; ``--expected`` runs only the files that the table names.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.planted_faults.table import FAULTS, Fault

ROOT = Path(__file__).parents[2]
TIERS = {"default": "not gate and not nightly", "gate": "gate", "nightly": "nightly"}
_LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv*", "*cache*", "__pycache__", "build", "dist", "*.egg-info"
)


def main(words: list[str]) -> int:
    """Try the named faults, or all of them; return 1 if one is caught by no tier."""
    parser = argparse.ArgumentParser("python -m tests.planted_faults", description=__doc__)
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="of a fault; without one all are tried"
    )
    parser.add_argument("--copy", type=Path, help="an existing copy of the sources")
    parser.add_argument(
        "--expected", action="store_true", help="run only the files that the table names"
    )
    asked = parser.parse_args(words)
    strange = sorted(set(asked.names) - {fault.name for fault in FAULTS})
    if strange:
        parser.error(f"no fault is called {', '.join(strange)}; see tests/planted_faults/table.py")
    missed = 0
    print("| fault | promise that it breaks | tier that catches it | first test that fails |")
    print("| --- | --- | --- | --- |", flush=True)
    with _copy_of_the_sources(asked.copy) as copy:
        for fault in FAULTS:
            if not asked.names or fault.name in asked.names:
                tier, test = _caught(fault, copy, expected_only=asked.expected)
                missed += tier == "none"
                print(f"| {fault.name} | {fault.promise} | {tier} | `{test}` |", flush=True)
    return 1 if missed else 0


@contextlib.contextmanager
def _copy_of_the_sources(there: Path | None) -> Iterator[Path]:
    if there is not None:
        yield there.resolve()
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "worldgen"
        shutil.copytree(ROOT, copy, ignore=_LEFT_OUT)
        yield copy


def _caught(fault: Fault, copy: Path, *, expected_only: bool) -> tuple[str, str]:
    """Return the first tier that catches a fault, and the test that catches it.

    That test must pass without the fault.
    """
    for tier, marks in TIERS.items():
        for paths in (fault.tests,) if expected_only else (fault.tests, ()):
            failing_anyway: list[str] = []
            while True:
                with _planted(fault, copy):
                    test = _first_that_fails(copy, marks, paths, failing_anyway)
                if not test:
                    break
                if "::" not in test:  # a run that could not start catches nothing
                    return "none", test
                if not _first_that_fails(copy, "", (test,)):
                    return tier, test
                failing_anyway.append(test)
    return "none", "-"


@contextlib.contextmanager
def _planted(fault: Fault, copy: Path) -> Iterator[None]:
    file = copy / fault.file
    before = file.read_text(encoding="utf-8")
    stamp = file.stat()
    file.write_text(before.replace(fault.text, fault.planted), encoding="utf-8")
    try:
        _compile(fault, copy)
        yield
    finally:
        file.write_text(before, encoding="utf-8")
        os.utime(
            file, ns=(stamp.st_atime_ns, stamp.st_mtime_ns)
        )  # the compiled core is correct again
        _compile(fault, copy)


def _compile(fault: Fault, copy: Path) -> None:
    """Compile the cores of the copy if the fault is in one."""
    if fault.file.endswith((".c", ".h")):
        command = [sys.executable, "-m", "build_tools.cores"]
        subprocess.run(
            command, cwd=copy, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )


def _first_that_fails(
    copy: Path, marks: str, paths: Sequence[str], left_out: Sequence[str] = ()
) -> str:
    """Run tests in the copy until one fails; return its name, or nothing if all pass."""
    options = ["-x", "-q", "-p", "no:cacheprovider", "--hypothesis-profile=unshrunk", "-m", marks]
    options += [f"--deselect={test}" for test in left_out]
    options += [] if paths else ["-n", "auto"]
    command = [sys.executable, "-m", "pytest", *options, *paths]
    here = os.environ | {"PYTHONPATH": str(copy)}
    done = subprocess.run(command, cwd=copy, env=here, capture_output=True, text=True, check=False)
    if done.returncode in (0, 5):  # all pass, or the tier has none of these tests
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    # The name ends where the message begins; it may contain spaces.
    return (
        failed[0].split(" ", 1)[1].split(" - ")[0]
        if failed
        else f"pytest ended with {done.returncode}"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
