"""Controllers in shared libraries.

Their declarations, refused ones, and what happens when they crash or hang.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from fuzz.studio.starting import check_controller
from sim import CONTROLLERS, RobotOptions, simulate
from sim.controllers.shared import guarded
from tests.helpers.command_line import worldgen
from tests.helpers.faulty_library import compile_faulty
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The library of faulty controllers, by its whole path."""
    return compile_faulty(tmp_path_factory.mktemp("library"))


@pytest.fixture
def contained(monkeypatch):
    """As in a campaign."""
    if os.name != "posix":
        pytest.skip("nothing is contained there")
    monkeypatch.setattr(guarded, "can_fork", True)


@pytest.fixture
def uncontained(monkeypatch):
    """As in ``worldgen run``."""
    monkeypatch.setattr(guarded, "can_fork", False)


def maze():
    return generate("maze", 3, size=20)


@pytest.mark.usefixtures("contained")
@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("segfault", "killed by SIGSEGV"),
        ("give_up", "killed by SIGABRT"),
        ("complain", "lost the map"),
    ],
)
def test_what_would_end_the_program_is_a_crash(name, error, library):
    episode = simulate(maze(), f"lib:{library}:{name}")
    assert (episode.verdict, episode.evidence.error) == ("crash", error) and episode.steps > 1


@pytest.mark.usefixtures("contained")
def test_the_next_run_after_a_crash_is_like_the_first(library):
    runs = [simulate(maze(), f"lib:{library}:segfault") for _ in range(3)]
    assert len({(run.verdict, run.steps, run.trace_digest) for run in runs}) == 1


@pytest.mark.gate
@pytest.mark.usefixtures("contained")
def test_an_endless_step_is_a_hang(library):
    episode = simulate(maze(), f"lib:{library}:hang")
    assert (episode.verdict, episode.evidence.error, episode.evidence.deadline) == (
        "hang",
        "no answer",
        1.0,
    )


@pytest.mark.usefixtures("uncontained")
def test_a_controller_can_say_in_process_what_is_wrong(library):
    episode = simulate(maze(), f"lib:{library}:complain")
    assert (episode.verdict, episode.evidence.error) == ("crash", "lost the map")


def test_a_run_is_bit_for_bit_the_same_in_a_process_of_its_own(library, monkeypatch):
    digests = []
    for state in (False, True):
        monkeypatch.setattr(guarded, "can_fork", state)
        digests.append(simulate(maze(), f"lib:{library}:complain").trace_digest)
    assert digests[0] == digests[1]


def test_it_has_what_it_offers(library):
    controller = CONTROLLERS.get(f"lib:{library}:complain")
    assert (controller.memory, controller.start_speed) == ((0.0, 0.25), 0.1)
    assert controller.needs == RobotOptions(beams=12, beam_range=0.5)
    assert "time" not in controller.senses and "random" in controller.senses


def test_senses_that_are_not_named_are_left_out(library):
    assert "signal" not in CONTROLLERS.get(f"lib:{library}:segfault").senses


def test_a_campaign_knows_the_file_by_its_content(library):
    assert CONTROLLERS.source(f"lib:{library}:complain") == library


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("absent", {"code": "offers-no-controller", "function": "absent"}),
        ("alone", {"code": "offers-no-controller", "function": "alone"}),
        ("old", {"code": "other-header-version", "version": 99, "wanted": 1}),
        ("small", {"code": "other-header-version", "size": 8}),
        ("clairvoyant", {"code": "unknown-senses"}),
    ],
)
def test_what_a_library_does_not_offer_is_refused(name, expected, library):
    with raises(InvalidParameter, **expected):
        CONTROLLERS.get(f"lib:{library}:{name}")


def test_a_library_that_is_not_there_is_refused():
    with raises(InvalidParameter, "no-such-file", file="absent.so"):
        CONTROLLERS.get("lib:./absent.so:act")


def test_a_file_that_is_no_library_is_refused(tmp_path):
    (tmp_path / "robot.so").write_text("int act;")
    with raises(InvalidParameter, "cannot-load"):
        CONTROLLERS.get(f"lib:{tmp_path}/robot.so:act")


@pytest.mark.parametrize("name", ["lib:", "lib:./robot.so", "lib:./robot.so:", "lib::act"])
def test_a_name_without_file_or_function_is_refused(name):
    with raises(InvalidParameter, "no-function-named"):
        CONTROLLERS.get(name)


def test_the_command_line_says_where_the_header_is():
    folder = Path(worldgen("--include").out.strip())
    assert (folder / "worldgen_controller.h").is_file()


def test_the_core_reads_the_observation_as_the_library_does(library):
    controller = CONTROLLERS.get(f"lib:{library}:complain")
    command = np.zeros(3)
    seen = np.zeros(17 + 12)
    seen[7] = 0.5  # target heading
    seen[10] = 0.02  # time step
    seen[11] = 2.0  # top speed
    controller.act(seen, np.array(controller.memory), command)
    assert command.tolist() == [2.0, 25.0, 0.0]


def test_the_studio_looks_for_the_file_and_does_not_load_it(tmp_path):
    (tmp_path / "robot.so").write_text("int act;")
    check_controller(f"lib:{tmp_path}/robot.so:act")
    with raises(InvalidParameter, "no-such-file"):
        check_controller(f"lib:{tmp_path}/absent.so:act")
