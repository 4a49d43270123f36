"""Each benchmark still runs: every program in benchmarks/ has a round that takes seconds."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.browser import missing_browser

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "benchmarks"
PROGRAMS = sorted(
    [
        *(file.stem for file in FOLDER.glob("*.py") if "__main__" in file.read_text()),
        *(file.parent.name for file in FOLDER.glob("*/__main__.py")),
    ]
)


@pytest.mark.gate
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_benchmark_has_a_tiny_round(name):
    assert importlib.import_module(f"benchmarks.{name}").TINY is not None


@pytest.mark.nightly
@pytest.mark.parametrize("name", PROGRAMS)
def test_a_tiny_round_of_a_benchmark_runs(name):
    module = importlib.import_module(f"benchmarks.{name}")
    if hasattr(module, "chromium_browser") and missing_browser():
        pytest.skip(missing_browser())
    command = [sys.executable, "-m", f"benchmarks.{name}", *module.TINY]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
