"""The table of planted faults fits the sources; ``python -m tests.planted_faults`` runs it."""

import ast
from pathlib import Path

import pytest

from tests.planted_faults.table import FAULTS

ROOT = Path(__file__).parents[2]
each_fault = pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)


@each_fault
def test_a_fault_can_be_planted_in_exactly_one_place(fault):
    assert (ROOT / fault.file).read_text(encoding="utf-8").count(fault.text) == 1


@pytest.mark.parametrize(
    "fault", [fault for fault in FAULTS if fault.file.endswith(".py")], ids=lambda fault: fault.name
)
def test_with_a_fault_the_source_is_another_program(fault):
    before = (ROOT / fault.file).read_text(encoding="utf-8")
    planted = before.replace(fault.text, fault.planted)
    assert ast.dump(ast.parse(planted)) != ast.dump(ast.parse(before))


@each_fault
def test_the_files_that_are_expected_to_catch_a_fault_are_there(fault):
    assert fault.tests and all((ROOT / name).is_file() for name in fault.tests)


def test_every_package_has_a_fault_and_no_two_have_one_name():
    assert {fault.file.partition("/")[0] for fault in FAULTS} == {
        "worldgen",
        "sim",
        "fuzz",
        "worldgen_plugins",
    }
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 30
