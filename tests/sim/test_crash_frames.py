"""Where a Python controller raised: whose frames count."""

import pytest

from sim import simulate
from sim.controllers.crash_frames import crash_facts, crash_text
from sim.verdict import Verdict
from tests.helpers.drawn_worlds import drawn

ROBOT = "/home/ann/robot.py"


class Robot:
    def act(self, observation, memory):
        raise NotImplementedError


def raised_through(library):
    """The exception is raised in a library's file,

    in a function that the user's file calls.
    """
    names = {}
    exec(compile("def solve():\n    return 1 / 0\n", library, "exec"), names)
    exec(compile("def plan():\n    return solve()\n", ROBOT, "exec"), names)
    with pytest.raises(ZeroDivisionError) as caught:
        names["plan"]()
    return caught.value.with_traceback(caught.tb.tb_next)


@pytest.mark.parametrize(
    "library",
    [
        "/usr/lib/python3/dist-packages/solver/core.py",
        "/opt/other/lib/python3.12/site-packages/solver.py",
    ],
)
def test_an_installed_library_is_not_the_users_code(library):
    assert [
        frame["function"] for frame in crash_facts(raised_through(library), Robot())["frames"]
    ] == ["plan"]


def test_a_file_that_only_has_a_similar_name_is_the_users_code():
    error = raised_through("/home/ann/my-dist-packages/solver.py")
    assert [frame["function"] for frame in crash_facts(error, Robot())["frames"]] == [
        "plan",
        "solve",
    ]


class Unsayable(Exception):
    def __str__(self):
        raise RuntimeError("no words")


class Speechless:
    def reset(self):
        return ()

    def act(self, observation, memory):
        raise Unsayable


def test_an_exception_without_words_is_named_by_its_type():
    assert crash_text(ValueError("a gap")) == "ValueError: a gap"
    assert crash_text(Unsayable()) == "Unsayable"
    outcome = simulate(drawn("#####\n#S.G#\n#####", radius=0.05), Speechless())
    assert outcome.verdict == Verdict.CRASH and outcome.evidence.error == "Unsayable"
