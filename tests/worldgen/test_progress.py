"""What takes long says so, and nothing else is printed."""

import logging

import pytest

from worldgen import progress
from worldgen.progress import Display, display_on_stderr, set_verbosity, working


class Clock:
    """A clock that goes on only when it is told to."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


def watched(clock, monkeypatch, **settings):
    """A display without its thread, which is looked at by hand."""
    display = Display(clock=clock, **settings)
    monkeypatch.setattr(progress, "_display", display)
    monkeypatch.setattr(Display, "_watch", lambda self, over: None)
    return display


def test_work_under_two_seconds_prints_nothing(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    with working("digging"):
        clock.now = 1.9
        display.tick()
    assert capsys.readouterr().err == ""


def test_off_a_terminal_a_line_comes_after_two_seconds_and_then_every_few(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    with working("digging"):
        for _ in range(44):
            clock.now += 0.25
            display.tick()
    assert capsys.readouterr().err == "digging (2.0 s)\ndigging (7.0 s)\n"


def test_on_a_terminal_one_line_is_drawn_in_place_and_taken_away(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=True)
    with working("digging"):
        for _ in range(9):
            clock.now += 0.25
            display.tick()
    assert capsys.readouterr().err == "\r\x1b[Kdigging (2.0 s)\r\x1b[Kdigging (2.2 s)\r\x1b[K"


def test_a_live_line_is_cut_to_the_terminal_and_keeps_the_time(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=True)
    monkeypatch.setattr(progress, "_columns", lambda: 30)
    with working("digging " * 10):
        clock.now = 3.0
        display.tick()
        drawn = capsys.readouterr().err.removeprefix("\r\x1b[K")
    assert len(drawn) == 29
    assert drawn.endswith("... (3.0 s)")


def test_a_live_line_that_is_too_long_leaves_out_the_outer_work_first(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=True)
    monkeypatch.setattr(progress, "_columns", lambda: 30)
    with working("digging a hole"), working("resting in it"):
        clock.now = 3.0
        display.tick()
        assert capsys.readouterr().err == "\r\x1b[Kresting in it (3.0 s)"


def test_another_message_counts_as_said_and_takes_the_live_line_away(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=True)
    with working("digging"):
        clock.now = 2.0
        display.tick()
        capsys.readouterr()
        progress.spoke()
        clock.now = 3.9
        display.tick()
        assert capsys.readouterr().err == "\r\x1b[K"


def test_work_within_work_is_one_line(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    with working("digging"), working("resting"), working("digging"):
        clock.now = 2.0
        display.tick()
    assert capsys.readouterr().err == "digging; resting (2.0 s)\n"


def test_counted_work_shows_rate_and_time_left(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    with working("digging") as work:
        work.count(0, 10_000, "holes")
        clock.now = 4.0
        work.count(2_000, 10_000, "holes")
        display.tick()
    assert capsys.readouterr().err == "digging: 2,000 of 10,000 holes (500/s, 16 s left) (4.0 s)\n"


def test_what_a_terminal_would_obey_is_escaped(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    with working("digging \x1b[2J"):
        clock.now = 2.0
        display.tick()
    assert "\x1b" not in capsys.readouterr().err


def test_a_quiet_command_says_nothing(clock, monkeypatch, capsys):
    display = watched(clock, monkeypatch, terminal=False)
    set_verbosity(-1)
    with working("digging"):
        clock.now = 9.0
        display.tick()
    assert capsys.readouterr().err == ""


def test_a_verbose_command_says_when_work_begins_and_ends(clock, monkeypatch, capsys):
    watched(clock, monkeypatch, terminal=False)
    set_verbosity(1)
    with working("digging"):
        clock.now = 1.0
    assert capsys.readouterr().err == "digging ...\ndigging: done in 1.0 s\n"


def test_library_use_prints_nothing_and_logs(capsys, caplog):
    with caplog.at_level(logging.INFO, "worldgen"), working("digging") as work:
        work.count(1, 2)
    assert caplog.messages == ["digging"]
    assert capsys.readouterr().err == ""


def test_library_use_logs_how_far_counted_work_is_every_few_seconds(clock, monkeypatch, caplog):
    monkeypatch.setattr(progress, "_clock", clock)
    with caplog.at_level(logging.INFO, "worldgen"), working("digging") as work:
        for done in range(13):
            clock.now = float(done)
            work.count(done, 12, "holes")
    assert caplog.messages == [
        "digging",
        "digging: 5 of 12 holes (1/s, 7.0 s left)",
        "digging: 10 of 12 holes (1/s, 2.0 s left)",
    ]


def test_an_error_within_work_ends_it(monkeypatch):
    monkeypatch.delenv("WORLDGEN_PROGRESS")
    with display_on_stderr() as display:
        with pytest.raises(KeyboardInterrupt), working("digging"):
            raise KeyboardInterrupt
        assert display._works == []


def test_a_closed_standard_error_ends_no_work(clock, monkeypatch):
    display = watched(clock, monkeypatch, terminal=False)
    monkeypatch.setattr("sys.stderr", None)
    with working("digging"):
        clock.now = 5.0
        display.tick()


def test_a_warning_is_said_once(clock, monkeypatch, capsys):
    watched(clock, monkeypatch, terminal=False)
    monkeypatch.setattr(progress, "_said", set())
    for _ in range(2):
        progress.say_once("the spade is blunt")
    assert capsys.readouterr().err == "warning: the spade is blunt\n"
