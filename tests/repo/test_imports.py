"""The arrows between the packages hold."""

from pathlib import Path

from importlinter.application.use_cases import lint_imports
from importlinter.cli import EXIT_STATUS_SUCCESS  # noqa: F401 - loads the linter's settings

ROOT = Path(__file__).parents[2]


def test_import_contracts_hold():
    assert lint_imports(config_filename=str(ROOT / "pyproject.toml"))
