"""The C cores: clang-tidy reports nothing, and prover and simulator share no code."""

import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from build_tools.cores import CORES, FAULTS, ROOT

INCLUDED = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
SHARED = {"wg_types.h"}
ALL = (*CORES, FAULTS)
C_FILES = sorted({file for core in ALL for file in core.c_files()})


QUICK = "--checks=-clang-analyzer-*"  # the analyzer takes nine tenths of the time


@pytest.mark.parametrize(
    "options",
    [pytest.param([QUICK], marks=pytest.mark.gate), pytest.param([], marks=pytest.mark.nightly)],
)
def test_clang_tidy_finds_nothing(options):
    tool = shutil.which("clang-tidy", path=str(Path(sys.executable).parent))
    if tool is None:
        pytest.skip("NOT CHECKED: pip install -e '.[dev]' brings clang-tidy")
    folders = sorted({folder for core in ALL for folder in core.includes})
    compiling = ["-std=c17", *(f"-I{ROOT / folder}" for folder in folders)]

    def findings(file):
        command = [tool, "--quiet", *options, str(file), "--", *compiling]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        return done.stdout if done.returncode else ""

    with ThreadPoolExecutor() as pool:
        found = "".join(pool.map(findings, C_FILES))
    assert not found, found


def headers_of(folders):
    """Return the names of the headers in some folders."""
    return {file.name for folder in folders for file in (ROOT / folder).rglob("*.h")}


def test_prover_and_simulator_share_one_header_of_types():
    prover = headers_of(["worldgen/core", "worldgen/include"])
    simulator = headers_of(["sim/core", "sim/include"])
    assert not prover & simulator
    for file in [*(ROOT / "sim").rglob("*.[ch]"), *(ROOT / "fuzz").rglob("*.[ch]")]:
        names = {Path(name).name for name in INCLUDED.findall(file.read_text(encoding="utf-8"))}
        assert names & prover <= SHARED, f"{file.relative_to(ROOT)} includes code of the prover"
    for file in (ROOT / "worldgen").rglob("*.[ch]"):
        names = {Path(name).name for name in INCLUDED.findall(file.read_text(encoding="utf-8"))}
        assert not names & simulator, f"{file.relative_to(ROOT)} includes code of the simulator"


def test_what_checks_certificates_and_audits_is_plain_python():
    checkers = [*(ROOT / "worldgen/reach/check").glob("*.py"), *(ROOT / "sim/audit").glob("*.py")]
    assert len(checkers) > 6
    assert not [file.name for file in checkers if "_core" in file.read_text(encoding="utf-8")]
