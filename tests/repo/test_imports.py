"""The packages import each other only as allowed."""

import subprocess
import sys
from pathlib import Path

from importlinter.application.use_cases import lint_imports
from importlinter.cli import EXIT_STATUS_SUCCESS  # noqa: F401 - loads the linter's settings

ROOT = Path(__file__).parents[2]


def test_import_contracts_hold():
    assert lint_imports(config_filename=str(ROOT / "pyproject.toml"))


def test_a_campaign_begins_without_what_only_some_strategies_need():
    heavy = ["hypothesis", "scipy.special", "pytest"]
    modules = "fuzz.commands._session, fuzz.campaign.unit, fuzz.ci, fuzz.report"
    code = f"import sys, {modules}; print(sorted(set({heavy}) & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
