"""What is compiled before the tests' workers start still works; a task that fails would only make the tests slower."""

import pytest

from tests.helpers.kernels import TASKS

pytestmark = pytest.mark.gate


@pytest.mark.parametrize("name", TASKS)
def test_a_task_runs(name):
    TASKS[name]()
