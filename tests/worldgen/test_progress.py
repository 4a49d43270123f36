"""Slow work is reported, and nothing else is printed."""

import logging
import os
import select
import sys
import time

import pytest

from worldgen import family
from worldgen.cli.output import ask_user
from worldgen.errors import GenerationFailed
from worldgen.generation import generate
from worldgen.reach.joint import placing
from worldgen.support import progress
from worldgen.support.progress import Display, display_on_stderr, set_verbosity, working


class Clock:
    """A clock that only moves on request."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


class Watched:
    """A display without its thread, updated by hand, and its output."""

    def __init__(self, terminal, capsys):
        self.clock = Clock()
        self._display = Display(clock=self.clock, terminal=terminal)
        self._capsys = capsys

    def at(self, now):
        """Read the clock at this time."""
        self.clock.now = now
        self._display.tick()

    def printed(self):
        return self._capsys.readouterr().err


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def watched(request, monkeypatch, capsys):
    """A display on the command line's standard error, which is not a terminal unless a test
    requires one.
    """
    monkeypatch.setattr(Display, "_watch", lambda self, over: None)
    made = Watched(getattr(request, "param", False), capsys)
    monkeypatch.setattr(progress, "_display", made._display)
    return made


on_a_terminal = pytest.mark.parametrize("watched", [True], ids=["terminal"], indirect=True)


def test_work_under_two_seconds_prints_nothing(watched):
    with working("digging"):
        watched.at(1.9)
    assert watched.printed() == ""


def test_off_a_terminal_a_line_comes_after_two_seconds_and_then_every_few(watched):
    with working("digging"):
        for quarter in range(1, 45):
            watched.at(quarter / 4)
    assert watched.printed() == "digging (2.0 s)\ndigging (7.0 s)\n"


@on_a_terminal
def test_on_a_terminal_one_line_is_drawn_in_place_and_taken_away(watched):
    with working("digging"):
        for quarter in range(1, 10):
            watched.at(quarter / 4)
    assert watched.printed() == "\r\x1b[Kdigging (2.0 s)\r\x1b[Kdigging (2.2 s)\r\x1b[K"


@on_a_terminal
def test_a_live_line_is_cut_to_the_terminal_and_keeps_the_time(watched, monkeypatch):
    monkeypatch.setattr(progress, "_columns", lambda: 30)
    with working("digging " * 10):
        watched.at(3.0)
        drawn = watched.printed().removeprefix("\r\x1b[K")
    assert len(drawn) == 29
    assert drawn.endswith("... (3.0 s)")


@on_a_terminal
def test_a_live_line_that_is_too_long_leaves_out_the_outer_work_first(watched, monkeypatch):
    monkeypatch.setattr(progress, "_columns", lambda: 30)
    with working("digging a hole"), working("resting in it"):
        watched.at(3.0)
        assert watched.printed() == "\r\x1b[Kresting in it (3.0 s)"


@on_a_terminal
def test_another_message_counts_as_said_and_takes_the_live_line_away(watched):
    with working("digging"):
        watched.at(2.0)
        watched.printed()
        progress.spoke()
        watched.at(3.9)
        assert watched.printed() == "\r\x1b[K"


def test_work_within_work_is_one_line(watched):
    with working("digging"), working("resting"), working("digging"):
        watched.at(2.0)
    assert watched.printed() == "digging; resting (2.0 s)\n"


def test_of_short_work_after_other_short_work_no_time_is_said(watched):
    with working("digging"):
        watched.at(1.9)
    with working("resting"):
        watched.at(2.0)
    assert watched.printed() == "resting\n"


def test_counted_work_shows_rate_and_time_left(watched):
    with working("digging") as work:
        work.count(0, 10_000, "holes")
        watched.clock.now = 4.0
        work.count(2_000, 10_000, "holes")
        watched.at(4.0)
    assert watched.printed() == "digging: 2,000 of 10,000 holes (500/s, 16 s left) (4.0 s)\n"


def test_what_a_terminal_would_obey_is_escaped(watched):
    with working("digging \x1b[2J"):
        watched.at(2.0)
    assert "\x1b" not in watched.printed()


def test_a_quiet_command_says_nothing(watched):
    set_verbosity(-1)
    with working("digging"):
        watched.at(9.0)
    assert watched.printed() == ""


def test_a_verbose_command_says_when_work_begins_and_ends(watched):
    set_verbosity(1)
    with working("digging"):
        watched.clock.now = 1.0
    assert watched.printed() == "digging ...\ndigging: done in 1.0 s\n"


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


def test_a_closed_standard_error_ends_no_work(watched, monkeypatch):
    monkeypatch.setattr("sys.stderr", None)
    with working("digging"):
        watched.at(5.0)


def test_a_warning_is_said_once(watched, monkeypatch):
    monkeypatch.setattr(progress, "_said", set())
    for _ in range(2):
        progress.say_once("the spade is blunt")
    assert watched.printed() == "warning: the spade is blunt\n"


def test_placing_robots_says_which_of_how_many_layouts_is_tried(watched, monkeypatch):
    decide = family.decide

    def decide_slowly(*args, **options):
        watched.at(watched.clock.now + 20.0)
        return decide(*args, **options)

    monkeypatch.setattr(family, "decide", decide_slowly)
    with pytest.raises(GenerationFailed):
        generate("rooms", 1, robots=10, size=12)
    said = watched.printed()
    assert "placing 10 robots in layout 2 of at most 12: placement 1 of 4 (" in said
    # With few robots, the first layout seldom takes long.
    assert "layout 1 of" not in said


def test_placing_many_robots_says_so_in_the_first_layout(watched, monkeypatch):
    class EnoughSeen(Exception):
        pass

    def look(*args, **options):
        watched.at(20.0)
        raise EnoughSeen

    monkeypatch.setattr(placing, "Crowd", look)
    with pytest.raises(EnoughSeen):
        generate("doorway", 1, robots=60)
    assert "placing 60 robots in layout 1 of at most 6" in watched.printed()


def test_nothing_is_drawn_over_a_question_at_the_terminal(clock, monkeypatch):
    monkeypatch.setattr(progress, "_REDRAW", 0.0001)
    ours, terminal = os.openpty()
    ticks = []
    tick = Display.tick

    def counted_tick(display):
        tick(display)
        ticks.append(display)

    def answer_later(text, **settings):
        """Answer as a user does: after the thread has had many chances to draw."""
        os.write(terminal, text.encode())
        clock.now += 100.0
        before = len(ticks)
        while len(ticks) < before + 50:
            time.sleep(0.0001)
        os.write(terminal, b" y.")
        return True

    monkeypatch.setattr(Display, "tick", counted_tick)
    monkeypatch.setattr("click.confirm", answer_later)
    display = Display(clock=clock)
    monkeypatch.setattr(progress, "_display", display)
    with open(terminal, "w", encoding="utf-8") as stderr:  # noqa: PTH123 - it has no path
        monkeypatch.setattr(sys, "stderr", stderr)
        with working("reading"):
            clock.now += 3.0
            display.tick()
            assert ask_user("Run it?")
            clock.now += 3.0
            display.tick()
        display.close()
        # The terminal passes on what is written a little later, and in parts.
        written = b""
        while select.select([ours], [], [], 1.0)[0]:
            written += os.read(ours, 10_000)
        drawn = written.decode()
    os.close(ours)
    before, asked, after = drawn.partition("Run it? y.")
    assert "reading" in before and asked and "reading" in after
