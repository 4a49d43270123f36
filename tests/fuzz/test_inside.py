"""Which lines of a controller run where it fails, and what its state does there."""

import json
import re
import sys
from pathlib import Path

import pytest

from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview.building import with_worlds
from fuzz.overview.causes import causes_of
from fuzz.triage.inside import inside
from sim.controllers import CONTROLLERS
from tests.helpers.command_line import worldgen
from tests.helpers.halls import cup
from worldgen import write_world
from worldgen.plugins.counted_code import counted_module
from worldgen.world import FailureRecord

# Bounces to and fro in the cup; its second branch is never reached there.
BOUNCES = '''
"""A file with a docstring, and a future import after it."""
from __future__ import annotations
import math
from dataclasses import dataclass
from sim import Command

TURN = math.radians(175)
UNUSED = 3


@dataclass
class Robot:
    """Turns nearly around at each wall."""

    patience: int = 5

    def reset(self):
        """Return no memory."""
        self.side = 1
        self.calls = 0
        self.first = None
        return (0.0,)

    def never_called(self):
        return 0.0

    def act(self, observation, memory):
        (waiting,) = memory
        self.calls += 1
        if observation.bump and self.calls % 3:
            self.side = -self.side if observation.x > 0 else 1
            if self.first is None:
                self.first = round(observation.x, 3)
            turn = self.side * TURN
        elif observation.x > 1e6:
            turn = self.never_called()
        else:
            turn = 0.0
        return Command(
            observation.top_speed,
            turn / observation.time_step,
        ), (waiting,)
'''


@pytest.fixture
def robot(tmp_path):
    """The name of a controller with this source."""

    def write(source, name="Robot"):
        file = tmp_path / f"robot{len(list(tmp_path.iterdir()))}.py"
        file.write_text(source)
        return f"{file}:{name}"

    return write


def failing(name):
    world = certified(cup())
    facts = {"steps": 400, "time_step": 0.015}
    return Failure(world, FailureRecord(name, "swept", 0, "stalled", "0" * 16, facts))


def seen(name):
    failure = failing(name)
    return inside(failure, failure.run())


def times_of(found, text):
    """How often the first line with this text runs."""
    return next(line.times for line in found.lines if text in line.text)


def test_lines_that_run_in_the_last_part_are_counted_and_the_others_named(robot):
    found = seen(robot(BOUNCES))
    steps = int(re.search(r"([\d,]+) step", found.part)[1].replace(",", ""))
    assert times_of(found, "(waiting,) = memory") == steps
    bumps = times_of(found, "self.side = -self.side")
    assert 0 < bumps < steps
    assert times_of(found, "if self.first is None") == bumps
    assert times_of(found, "self.first = round") == 0
    assert times_of(found, "turn = self.never_called()") == 0
    assert times_of(found, "turn = 0.0") == steps - bumps
    assert found.unused == ["never_called"]


def test_functions_of_one_name_that_never_run_are_named_with_their_lines(robot):
    others = "\n\nclass Other{}:\n    def act(self, observation, memory):\n        return 0\n"
    found = seen(robot(BOUNCES + "".join(others.format(one) for one in (1, 2))))
    assert found.unused[0] == "never_called"
    assert [one.partition(" (line ")[0] for one in found.unused[1:]] == ["act", "act"]
    assert len(set(found.unused)) == 3


def test_a_statement_of_several_lines_has_one_count_and_a_header_none(robot):
    found = seen(robot(BOUNCES))
    counts = [times_of(found, text) for text in ("return Command(", "turn / observation.time")]
    assert counts[0] == counts[1] > 0
    assert times_of(found, "else:") is None
    assert times_of(found, "def act") is None


def test_constants_that_the_lines_use_are_shown_and_docstrings_are_not(robot):
    text = "\n".join(line.text for line in seen(robot(BOUNCES)).lines)
    assert "TURN = math.radians(175)" in text
    assert "UNUSED" not in text and "Return no memory" not in text


def test_state_that_changes_is_apart_from_state_that_stays(robot):
    state = dict(seen(robot(BOUNCES)).state)
    assert state["self.side"] in ("takes 1, -1", "takes -1, 1")
    assert state["self.calls"].startswith("only rises, from ")
    assert re.fullmatch(r"is [\d.]+ since step \d+", state["self.first"])
    always = state["the same in the whole run:"]
    assert "self.patience = 5" in always and "waiting (memory) = 0" in always


def test_senses_that_the_file_names_have_their_range(robot):
    state = dict(seen(robot(BOUNCES)).state)
    assert re.fullmatch(r"varies from [\d.]+ to [\d.]+ m", state["observation.x"])
    assert "observation.y" not in state and "observation.top_speed" not in state


def test_angles_that_it_senses_are_in_degrees(robot):
    source = BOUNCES.replace("observation.x > 1e6", "observation.heading > 1e6")
    assert dict(seen(robot(source)).state)["observation.heading"].endswith(" degrees")


def test_the_senses_that_its_functions_read_are_listed_but_not_its_own_attributes(robot):
    source = BOUNCES.replace("self.calls", "self.heading").replace(
        "return 0.0", "return observation.beams"
    )
    found = seen(robot(source))
    assert found.reads == ["bump", "x", "time_step", "top_speed"]
    last = found.text()[-1]
    assert last == "reads there, of what it senses: bump, x, time_step, top_speed"


def test_objects_enumerations_and_collections_are_state_too(robot):
    source = (
        BOUNCES.replace(
            "        self.side = 1\n",
            """        self.side = 1
        self.mode = Mode.ON
        self.filter = Filter()
        self.kept = []
""",
        )
        .replace(
            "        self.calls += 1\n",
            """        self.calls += 1
        self.filter.value += 0.5
        self.kept.append(observation)
""",
        )
        .replace(
            "@dataclass\n",
            """import enum

class Mode(enum.Enum):
    ON = 1

class Filter:
    def __init__(self):
        self.value = 0.0

@dataclass
""",
        )
    )
    state = dict(seen(robot(source)).state)
    assert state["self.filter.value"].startswith("only rises, from ")
    assert state["len(self.kept)"].startswith("only rises, from ")
    assert "self.mode = Mode.ON" in state["the same in the whole run:"]


def test_what_it_senses_is_named_where_it_is_the_same_in_every_step(robot):
    source = BOUNCES.replace("if observation.bump and", "if observation.target_distance < 0 and")
    state = dict(seen(robot(source)).state)
    same = state["the same in each of these steps:"]
    assert re.search(r"observation\.target_distance = [\d.]+ m", same)
    assert "top_speed" not in str(state)


def test_the_entries_of_a_small_table_and_the_numbers_of_a_pose_are_state(robot):
    source = BOUNCES.replace(
        "        self.side = 1\n",
        """        self.side = 1
        self.board = {"doing": "seek", "tries": 0, "seen": None, "steps": 0}
        self.pose = np.zeros(2)
        self.goal = [1.5, 2.5]
        self.table = {k: k for k in "abcdefghijklmnopqrstuvwxyz"}
""",
    ).replace(
        "        self.calls += 1\n",
        """        self.calls += 1
        self.board["seen"] = observation
        if self.board["tries"] >= 0:
            self.board["tries"] += 1
        self.pose += 0.5
""",
    )
    state = dict(seen(robot(f"import numpy as np\n{source[source.index('import math') :]}")).state)
    assert state["self.board['tries']"].startswith("only rises, from ")
    assert state["self.pose[1]"].startswith("only rises, from ")
    always = state["the same in the whole run:"]
    for text in ("self.board['doing'] = 'seek'", "self.goal[1] = 2.5", "len(self.table) = 26"):
        assert text in always
    assert "len(self.board)" not in str(state) and "len(self.pose)" not in str(state)
    # What the lines read that run there comes before what they don't.
    names = [*state]
    assert names.index("self.board['tries']") < names.index("self.first")


def test_a_long_function_is_cut_to_a_screen(robot):
    long = "\n".join(f"            turn = {k}.0" for k in range(300))
    source = BOUNCES.replace("            turn = self.never_called()", long)
    found = seen(robot(source))
    assert len(found.lines) <= 50
    assert any(line.text == "..." for line in found.lines)
    assert times_of(found, "turn = self.side * TURN") > 0


def test_functions_without_a_decision_give_way_to_those_that_decide(robot):
    plain = "".join(
        f"    def plain{k}(self):\n        a = {k}\n        return a\n\n" for k in range(30)
    )
    calls = "".join(f"        self.plain{k}()\n" for k in range(30))
    source = BOUNCES.replace("    def act(", f"{plain}    def act(").replace(
        "        self.calls += 1\n", f"        self.calls += 1\n{calls}"
    )
    found = seen(robot(source))
    text = "\n".join(line.text for line in found.lines)
    assert len(found.lines) <= 50
    assert "turn = self.side * TURN" in text and "a = 7" not in text


def test_the_controller_that_runs_otherwise_stays_as_it_is(robot):
    name = robot(BOUNCES)
    failure = failing(name)
    before = CONTROLLERS.get(name)
    module = sys.modules[type(before).__module__]
    code = type(before).act.__code__
    digest = failure.run().trace_digest
    assert inside(failure, failure.run()) is not None
    assert CONTROLLERS.get(name) is before
    assert sys.modules[type(before).__module__] is module
    assert type(before).act.__code__ is code
    assert failure.run().trace_digest == digest


def test_a_run_that_differs_from_the_recorded_one_shows_nothing(robot):
    name = robot(BOUNCES)
    failure = failing(name)
    episode = failure.run()
    assert inside(failure, episode) is not None
    Path(name.rpartition(":")[0]).write_text(BOUNCES.replace("175", "95"))
    assert inside(failure, episode) is None


@pytest.mark.parametrize("name", ["turn-right", "wall-left"])
def test_a_compiled_controller_has_no_lines(name):
    failure = failing(name)
    assert inside(failure, failure.run()) is None


def test_a_crash_shows_the_lines_of_its_last_step(robot):
    source = BOUNCES.replace("            turn = self.side * TURN", "            turn = 1 / 0")
    found = seen(robot(source))
    assert found.part == "its last step"
    assert times_of(found, "turn = 1 / 0") == 1
    assert times_of(found, "return Command(") == 0


def test_an_instance_in_a_file_has_lines_too(robot):
    found = seen(robot(f"{BOUNCES}\nmine = Robot(patience=7)\n", "mine"))
    assert "self.patience = 7" in dict(found.state)["the same in the whole run:"]


VECTOR = """
import numpy as np
from sim import Commands

class Robot:
    __slots__ = ("gain",)

    def reset(self):
        self.gain = 0.5
        return (0.0,)

    def act_many(self, observation, memory):
        turn = np.where(observation.bump, 3.0, 0.0)
        return Commands(observation.top_speed, turn / observation.time_step), memory + 1.0
"""


def test_a_class_for_many_robots_has_lines_too(robot):
    found = seen(robot(VECTOR))
    assert times_of(found, "turn = np.where") > 0
    state = dict(found.state)
    assert "self.gain = 0.5" in state["the same in the whole run:"]
    assert state["memory[0]"].startswith("only rises, from ")


def test_every_kind_of_statement_runs_as_before(tmp_path, monkeypatch):
    (tmp_path / "kinds.py").write_text('''
import contextlib
total = []

async def later():
    return 1

def run(kind):
    """Have a docstring."""
    global total
    total.append(kind)
    for number in range(3):
        if number == 1: continue
        elif number == 2:
            break
    else:
        total.append("not broken")
    while True:
        break
    try:
        raise KeyError(kind)
    except KeyError as error:
        total.append(str(error))
    finally:
        total.append("finally")
    with contextlib.suppress(ValueError):
        raise ValueError
    match kind:
        case "a" | "b":
            total.append("letter")
        case _:
            total.append("other")
    def inner():
        nonlocal number
        number += 1
        yield number
    return [*inner()], (lambda: 1)()
''')
    monkeypatch.syspath_prepend(tmp_path)
    import kinds

    plain = kinds.run("a")
    with counted_module(kinds) as code:
        assert kinds.run("a") == plain
        assert kinds.run.__doc__ == "Have a docstring."
    counts = {code.source[line - 1].strip(): code.counts[line] for line in code.statements}
    assert counts["if number == 1: continue"] == 3
    assert counts['total.append("not broken")'] == 0
    assert counts['total.append("letter")'] == 1
    assert counts['total.append("other")'] == 0
    assert counts["yield number"] == 1
    assert counts["return 1"] == 0


@pytest.mark.gate
def test_commands_show_lines_and_state_and_a_report_can_leave_them_out(robot, tmp_path):
    file = tmp_path / "failures" / "failure.grid"
    file.parent.mkdir()
    write_world(failing(robot(BOUNCES)).stored, file)
    explained = worldgen("explain", "--trust", file)
    assert "self.side = -self.side" in explained.out
    assert "self.calls only rises" in explained.out
    assert "touching a wall ahead" in explained.out
    (row,) = json.loads(worldgen("explain", "--trust", file, "--json").out)["failures"]
    assert row["inside"]["unused"] == ["never_called"] and row["reactions"]
    page = tmp_path / "report.html"
    assert worldgen("report", "--trust", file.parent, "--out", page).code == 0
    assert "turn = self.side * TURN" in page.read_text()
    assert (
        worldgen("report", "--trust", file.parent, "--out", page, "--no-code", "--force").code == 0
    )
    assert "self.side" not in page.read_text()
    assert "touching a wall ahead" in page.read_text()


def test_counts_do_not_depend_on_the_runs_before(robot):
    name = robot(BOUNCES)
    assert seen(name) == seen(name)


def test_an_overview_has_what_the_run_of_each_cause_shows(robot):
    failure = failing(robot(BOUNCES)).noting(cause="wanders")
    ((row,), _) = with_worlds(causes_of([failure]), lambda _: [failure])
    assert (0, None, "...") in row.inside.lines and row.inside.unused == ["never_called"]
    assert row.repeats and row.reactions[0].situation == "touching a wall ahead"


# Keeps a long list of counters; only its last number decides how the robot turns.
LONG_MEMORY = """
from sim import Command


class Robot:
    def reset(self):
        return (0.0,) * 31

    def act(self, observation, memory):
        decisive = memory[27] + observation.bump
        turn = decisive % 2 * 3.0
        counters = tuple(number + 1 for number in memory)
        memory = (*counters[:27], decisive, *counters[28:])
        return Command(observation.top_speed, turn / observation.time_step), memory
"""


def test_state_that_the_lines_read_comes_first_however_much_there_is(robot):
    state = seen(robot(LONG_MEMORY)).state
    assert state[0][0] == "memory[27]"
    assert ("and", "21 more that change") in state


def test_values_that_differ_each_time_or_run_code_when_looked_at_are_not_state(robot):
    source = BOUNCES.replace(
        "        self.side = 1\n",
        """        self.side = 1
        self.letters = frozenset("abcde")
        self.pair = (frozenset("abcde"), 1)
        self.object = object()
        self.zero = numpy.array(3.0)
        self.huge = 10**5000
        self.rude = Rude()
""",
    ).replace(
        "@dataclass\n",
        """import numpy

class Rude(int):
    def __len__(self):
        raise RuntimeError
    __eq__ = __repr__ = __hash__ = __len__

@dataclass
""",
    )
    state = str(seen(robot(source)).state)
    assert "self.zero = 3" in state and "len(self.letters) = 5" in state
    assert "len(self.pair) = 2" in state
    assert not re.search("object|huge|rude", state)


def test_a_run_that_is_too_long_is_not_run_again(robot, monkeypatch):
    monkeypatch.setattr("sim.episode.watched._MOST_STEPS", 399)
    assert seen(robot(BOUNCES)) is None
