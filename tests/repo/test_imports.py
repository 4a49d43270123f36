"""The packages import each other only as allowed."""

import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
from importlinter.application.use_cases import lint_imports
from importlinter.cli import EXIT_STATUS_SUCCESS  # noqa: F401 - loads the linter's settings

import fuzz
import sim
import worldgen

ROOT = Path(__file__).parents[2]


def test_import_contracts_hold():
    assert lint_imports(config_filename=str(ROOT / "pyproject.toml"))


@pytest.mark.parametrize("package", [fuzz, sim, worldgen], ids=lambda package: package.__name__)
def test_no_module_hides_a_public_name(package):
    modules = {one.name for one in pkgutil.iter_modules(package.__path__)}
    assert not modules & set(package.__all__)


def test_a_campaign_begins_without_what_only_some_strategies_need():
    heavy = ["hypothesis", "scipy.special", "pytest"]
    modules = "fuzz.commands._session, fuzz.campaign.unit, fuzz.ci.finding, fuzz.report"
    code = f"import sys, {modules}; print(sorted(set({heavy}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_replay_loads_neither_searches_nor_what_shows_their_results():
    unneeded = ["campaign", "corpus", "find", "overview", "player", "report", "search", "shrink"]
    failure = min((ROOT / "corpora/failures").rglob("*.grid"))
    code = f"""
import sys
from worldgen.cli.main import cli
cli(["replay", {str(failure)!r}], standalone_mode=False)
print(sorted({{name.split(".")[1] for name in sys.modules if name.startswith("fuzz.")}} & {set(unneeded)}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("1 of 1 confirmed\n[]\n")
