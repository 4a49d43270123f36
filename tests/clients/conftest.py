"""The tier of a real program's tests: gate if the gate installs the program, otherwise nightly."""

from pathlib import Path

import pytest

from tests.clients.install import GATE


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.parent == Path(__file__).parent:
            program = item.path.stem.removeprefix("test_")
            item.add_marker(pytest.mark.gate if program in GATE else pytest.mark.nightly)
