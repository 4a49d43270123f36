"""Buckets of crashes: unrelated crashes are kept apart, and edits to other lines do not split a
crash.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.facts.crash_bucket import crash_bucket
from fuzz.facts.signature import failure_class
from fuzz.shrink import shrink
from fuzz.triage.judging import failure_of
from sim.controllers.programs.crash_report import report_of
from sim.episode import Episode, simulate
from sim.evidence import FaultEvidence, fault_evidence
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen.reach import decide
from worldgen.world import Pose, Target, World


def arena(width=12):
    return World(np.zeros((8, width), bool), Pose(0.35, 0.35, 0.0), Target(1.0, 0.35, 0.05))


def controller(folder, body, name="mine"):
    lines = "\n".join(f"        {line}" for line in body.splitlines())
    code = f"""
class Mine:
    def reset(self):
        return (0.0,)

    def act(self, o, m):
{lines}
        return (1.0, 0.0), (m[0] + 1.0,)
"""
    path = folder / f"{name}.py"
    path.write_text(code)
    return f"{path}:Mine"


def bucket(name):
    from sim.controllers import CONTROLLERS

    CONTROLLERS.forget(name.rpartition(":")[0])
    return crash_bucket(simulate(arena(), name).evidence)


def test_a_bucket_names_the_exception_the_file_and_the_function(tmp_path):
    assert bucket(controller(tmp_path, "1 / 0")).startswith("ZeroDivisionError-mine.act-")


def test_lines_that_move_leave_the_bucket_as_it_is(tmp_path):
    before = bucket(controller(tmp_path, "1 / 0"))
    assert bucket(controller(tmp_path, "x = 1\n1 / 0")) == before


def test_another_folder_leaves_the_bucket_as_it_is(tmp_path):
    (tmp_path / "other").mkdir()
    assert bucket(controller(tmp_path / "other", "1 / 0")) == bucket(controller(tmp_path, "1 / 0"))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        pytest.param("raise ValueError('a')", "raise ValueError('b')", id="statements"),
        pytest.param(
            "raise ValueError(\n 'a')", "raise ValueError(\n 'b')", id="statements-of-two-lines"
        ),
        pytest.param(
            "raise ValueError",
            "if m[0] > 9:\n raise ValueError\nraise ValueError",
            id="equal-statements",
        ),
        pytest.param("raise ValueError", "raise KeyError", id="types"),
        pytest.param("(lambda: 1 / 0)()", "1 / 0", id="functions"),
    ],
)
def test_two_faults_in_one_function_have_two_buckets(one, other, tmp_path):
    assert bucket(controller(tmp_path, one)) != bucket(controller(tmp_path, other))


def test_a_recursion_without_end_has_one_bucket_wherever_the_stack_was_full(tmp_path):
    name = controller(tmp_path, "return self.act(o, m)")
    assert bucket(name) == "RecursionError-mine.act"


def aborted(said, step=5, **facts):
    stderr = said.splitlines()[-5:]
    return fault_evidence(
        {"signal": "SIGABRT", "step": step, "stderr": stderr, **report_of(said), **facts}
    )


def test_two_assertions_of_a_program_have_two_buckets():
    first, second = (
        aborted(f"robot: robot.c:12: act: Assertion `{text}' failed.\n")
        for text in ("gap > 0", "speed < 2")
    )
    assert crash_bucket(first).startswith("SIGABRT-assertion-robot.act-") and crash_bucket(
        first
    ) != crash_bucket(second)


def test_an_assertion_of_a_program_is_the_same_on_another_line():
    first, second = (
        aborted(f"robot: robot.c:{line}: act: Assertion `gap > 0' failed.\n") for line in (12, 40)
    )
    assert crash_bucket(first) == crash_bucket(second)


def test_the_last_words_of_a_program_that_aborts_are_in_its_bucket_without_their_numbers():
    first, second = (aborted(f"fatal: no plan at step {step}, 0x7f{step}\n") for step in (3, 17))
    assert crash_bucket(first) == crash_bucket(second) == "SIGABRT-fatal-no-plan-at-step"


@pytest.mark.parametrize("value", ["-3.5", "nan", "-inf", "1e-5"])
def test_neither_signs_nor_what_is_no_number_make_another_bucket(value):
    said = (
        "terminate called after throwing an instance of 'std::out_of_range'\n  what():  x out "
        "of range: {}\n"
    )
    assert crash_bucket(aborted(said.format(value))) == crash_bucket(aborted(said.format("3.5")))


def test_what_a_program_said_before_a_signal_that_it_did_not_raise_is_not_in_its_bucket():
    assert (
        crash_bucket(FaultEvidence(signal="SIGSEGV", step=5, stderr=("turning left",))) == "SIGSEGV"
    )


def test_silent_aborts_are_told_apart_by_where_the_run_stood():
    stands = [aborted("", step=1), aborted("", step=9), aborted("", step=9, bump=True)]
    assert [crash_bucket(evidence) for evidence in stands] == [
        "SIGABRT-first",
        "SIGABRT",
        "SIGABRT-bump",
    ]


@pytest.mark.parametrize("facts", [{"exception": "../x"}, {"signal": "../x"}, {}])
def test_a_name_that_could_be_a_path_is_not_in_a_bucket(facts):
    assert crash_bucket(FaultEvidence(**facts)) == ""


@pytest.mark.parametrize(
    ("verdict", "evidence", "kind"),
    [
        ("crash", {"exit_code": 3}, "crash-exit-3"),
        (
            "crash",
            {"exit_code": 1, "stderr": ["at step 3", "KeyError: 'x'"]},
            "crash-exit-1-KeyError",
        ),
        ("crash", {"error": "closed its output"}, "crash"),
        ("crash", {"exception": "ValueError"}, "crash-ValueError"),
        ("hang", {"error": "no answer"}, "hang"),
        ("invalid-command", {"rule": "unknown-key"}, "invalid-command-unknown-key"),
        ("invalid-command", {}, "invalid-command"),
    ],
)
def test_failures_of_a_controller_are_classed_by_what_it_did(verdict, evidence, kind):
    assert (
        failure_class(
            arena(), Episode(Verdict(verdict), 1, 0.015, 0.0, 0, "", fault_evidence(evidence))
        )
        == kind
    )


def test_shrinking_keeps_the_bucket_of_a_crash(tmp_path):
    body = (
        "if o.target_distance < 0.4:\n    raise ValueError('near')\nif m[0] > 2:\n    raise "
        "KeyError('late')"
    )
    name = controller(tmp_path, body)
    world = arena()
    failure = failure_of(
        replace(world, certificate=decide(world).certificate), Scenario.parse(name)
    )
    small = shrink(failure).failure
    assert small.record.details["class"] == failure.record.details["class"]
    assert small.world.width < world.width and "KeyError" in small.record.details["class"]


def test_the_recording_of_a_compiled_controller_ends_before_the_step_in_which_it_crashes():
    world = World(
        np.zeros((3, 4), bool), Pose(0.25, 0.15, -math.pi / 2), Target(0.05, 0.05, 0.05), 0.1
    )
    episode = simulate(world, "fuzz.faults:vfh_beam_beyond_the_last", record=True)
    assert episode.verdict == Verdict.CRASH and episode.trace.steps == episode.steps - 1
    assert episode.trace.digest() == episode.trace_digest
    assert episode.trace.x[-1] > 0.1
