"""The command ``worldgen verify``."""

import dataclasses
import json

import numpy as np
import pytest
from click.testing import CliRunner

from tests.helpers.drawn_worlds import drawn
from tests.helpers.raising import check_says
from worldgen.commands.verify import verify
from worldgen.errors import FormatError, InvalidParameter
from worldgen.files.grid import read_world, write_world
from worldgen.reach import decide
from worldgen.reach.verifying import verify_world
from worldgen.support.intervals import interval_95
from worldgen.timeline import CellState, Event, Timeline

ROOM = "#######\n#S...G#\n#######"
WALLED = ROOM.replace("..G", "#.G")
KEYS = {
    "path",
    "result",
    "certificate",
    "certificate_valid",
    "decided",
    "clearance",
    "radius",
    "reason",
}


def run(*words):
    return CliRunner().invoke(verify, [str(word) for word in words])


@pytest.fixture
def save(tmp_path):
    def write(name, text, *, proof=True, radius=0.05):
        world = drawn(text, radius=radius)
        if proof:
            world = dataclasses.replace(world, certificate=decide(world).certificate)
        write_world(world, tmp_path / name)
        return tmp_path / name

    return write


def test_a_true_witness_is_confirmed(save):
    result = run(save("w.grid", ROOM), "--json")
    answer = json.loads(result.stdout)
    assert set(answer) == KEYS
    assert (answer["result"], answer["certificate_valid"], answer["decided"]) == (
        "reachable",
        True,
        False,
    )
    assert (answer["clearance"], answer["radius"], result.exit_code) == (
        pytest.approx(0.05),
        0.05,
        0,
    )


def test_a_true_cut_is_confirmed(save):
    result = run(save("w.grid", WALLED), "--json")
    answer = json.loads(result.stdout)
    assert (answer["result"], answer["certificate"], answer["clearance"]) == ("blocked", "cut", 0.0)
    assert result.exit_code == 0


@pytest.mark.parametrize(("text", "word"), [(ROOM, "reachable"), (WALLED, "blocked")])
def test_a_map_without_a_certificate_is_decided_afresh(save, text, word):
    result = run(save("w.grid", text, proof=False))
    assert f"{word} for a disc of 0.05 m" in result.stdout
    assert "decided again and checked" in result.stdout
    assert result.exit_code == 0


def test_another_radius_is_decided_afresh_where_the_certificate_is_silent(save):
    answer = json.loads(run(save("w.grid", ROOM), "--radius", "0.0501", "--json").stdout)
    assert (answer["result"], answer["decided"], answer["radius"]) == ("blocked", True, 0.0501)


def test_a_smaller_radius_is_proved_by_the_same_witness(save):
    answer = json.loads(run(save("w.grid", ROOM), "--radius", "0.03", "--json").stdout)
    assert (answer["result"], answer["decided"]) == ("reachable", False)


def test_a_false_certificate_is_a_failure(save, tmp_path):
    path = save("w.grid", ROOM)
    path.write_text(path.read_text().replace("#S...G#", "#S.#.G#").replace("#.....#", "#..#..#"))
    result = run(path)
    assert "witness does not hold: the witness comes within 0 m" in result.stdout
    assert result.exit_code == 1


def test_several_worlds_end_with_a_summary_that_names_the_unsolvable_ones(save, tmp_path):
    save("a.grid", ROOM), save("b.grid.gz", WALLED), save("c.grid", ROOM)
    answer = json.loads(run(tmp_path, "--json").stdout)
    assert [item["result"] for item in answer["files"]] == ["reachable", "blocked", "reachable"]
    assert answer["summary"] == {
        "worlds": 3,
        "reachable": 2,
        "blocked": 1,
        "undecided": 0,
        "share": pytest.approx(2 / 3),
        "interval": [pytest.approx(low_or_high) for low_or_high in interval_95(2, 3)],
        "first_blocked": [str(tmp_path / "b.grid.gz")],
    }
    *lines, total, blocked = run(tmp_path).stdout.splitlines()
    assert len(lines) == 3
    assert total == (
        "3 worlds: 2 reachable, 66.7 % (95 % interval 9.4 to 99.2), 1 blocked, 0 undecided"
    )
    assert blocked == f"blocked: {tmp_path / 'b.grid.gz'}"


def test_a_summary_names_ten_unsolvable_worlds_and_counts_the_others(save, tmp_path):
    for number in range(12):
        save(f"{number:02}.grid", WALLED)
    last = run(tmp_path).stdout.splitlines()[-1]
    assert last.endswith("09.grid and 2 more") and "10.grid" not in last


def test_ctrl_c_keeps_the_summary_of_the_worlds_so_far(save, tmp_path, monkeypatch):
    def stop_at_the_third(world, radius, deadline, seen=[]):  # noqa: B006 - it counts the calls
        seen.append(world)
        if len(seen) == 3:
            raise KeyboardInterrupt
        return verify_world(world, radius, deadline)

    for name in "abc":
        save(f"{name}.grid", ROOM)
    monkeypatch.setattr("worldgen.reach.verifying.verify_world", stop_at_the_third)
    result = run(tmp_path)
    assert result.exit_code == 130
    assert "2 worlds: 2 reachable" in result.stdout and "interrupted" in result.stderr
    stop_at_the_third.__defaults__[0].clear()
    answer = json.loads(run(tmp_path, "--json").stdout)
    assert (answer["summary"]["worlds"], answer["summary"]["interrupted"]) == (2, True)


def test_one_false_certificate_of_several_is_a_failure(save, tmp_path):
    bad, good = drawn(ROOM), save("a.grid", ROOM)
    false = dataclasses.replace(
        decide(drawn(ROOM, radius=0.05)).certificate, x=np.array([0.15, 0.45])
    )
    write_world(dataclasses.replace(bad, certificate=false), tmp_path / "bad.grid")
    assert run(good, tmp_path / "bad.grid").exit_code == 1


def test_a_folder_without_worlds_is_refused(tmp_path):
    check_says(run(tmp_path).exception, "no-map-found")


def test_a_missing_file_is_refused(tmp_path):
    check_says(run(tmp_path / "none.grid").exception, "no-such-file")


def test_a_broken_file_is_an_error_of_the_format(tmp_path):
    (tmp_path / "w.grid").write_text("nonsense")
    assert isinstance(run(tmp_path / "w.grid").exception, FormatError)


def test_a_negative_radius_is_refused(save):
    assert isinstance(run(save("w.grid", ROOM), "--radius", "-1").exception, InvalidParameter)


@pytest.mark.gate
@pytest.mark.parametrize(
    ("text", "largest"),
    [
        (ROOM, 0.05),  # half the corridor
        (WALLED, 0.0),
        (
            "......#\n.G...#.\n....#..\n.......\n..#....\n.#...S.\n#......",
            0.05 * 2**0.5,
        ),  # between two corners
    ],
)
def test_the_largest_disc_that_could_pass_is_the_bottleneck(save, text, largest):
    path = save("w.grid", text, proof=False)
    found = json.loads(run(path, "--widest", "--json").stdout)["widest"]
    assert found == pytest.approx(largest, abs=1e-15)
    assert f"could pass at all: {found:.6g} m" in run(path, "--widest").stdout
    if found:
        assert decide(read_world(path), radius=found * (1 - 1e-6)).result == "reachable"
        assert decide(read_world(path), radius=found * (1 + 1e-6)).result == "blocked"


def test_the_largest_disc_is_not_known_of_a_world_that_changes(save, tmp_path):
    world = dataclasses.replace(
        drawn(ROOM, radius=0.05), timeline=Timeline.of([Event(1.0, 3, 1, CellState.BURNING)])
    )
    write_world(world, tmp_path / "w.grid")
    result = CliRunner().invoke(verify, [str(tmp_path / "w.grid"), "--widest"])
    check_says(result.exception, "world-changes")
    assert result.stdout == ""


def test_among_several_worlds_one_without_a_largest_disc_says_so(save, tmp_path):
    save("b.grid", ROOM)
    changing = dataclasses.replace(
        drawn(ROOM, radius=0.05), timeline=Timeline.of([Event(1.0, 3, 1, CellState.BURNING)])
    )
    for name in ("a.grid", "c.grid"):
        write_world(changing, tmp_path / name)
    result = run(tmp_path, "--widest", "--json")
    files = json.loads(result.stdout)["files"]
    assert [item.get("widest") for item in files] == [None, pytest.approx(0.05), None]
    assert ["widest" in item for item in files] == [False, True, False]
    assert files[0]["widest_unknown"] == "world-changes" and result.exit_code == 0
    lines = run(tmp_path, "--widest").stdout.splitlines()
    assert len(lines) == 4 and lines[3].startswith("3 worlds")
    assert lines[0].endswith("is not defined: the world changes") and "0.05 m" in lines[1]


@pytest.fixture
def burning(save, tmp_path):
    events = [Event(3.05, 3, 1, CellState.BURNING), Event(6.0, 3, 1, CellState.SOLID)]
    world = dataclasses.replace(
        drawn(ROOM, radius=0.05), robot_speed=0.1, timeline=Timeline.of(events)
    )
    write_world(
        dataclasses.replace(world, certificate=decide(world).certificate), tmp_path / "w.grid"
    )
    return tmp_path / "w.grid"


def test_a_world_that_changes_tells_how_late_the_robot_may_set_out(burning):
    result = run(burning, "--json")
    answer = json.loads(result.stdout)
    assert set(answer) == KEYS | {"margin", "latest_start"} and result.exit_code == 0
    assert answer["margin"] == pytest.approx(0.0, abs=0.1) and answer[
        "latest_start"
    ] == pytest.approx(answer["margin"])
    assert (
        "the witness may begin up to" in run(burning).stdout
        and "may wait until" in run(burning).stdout
    )


@pytest.mark.parametrize(
    ("deadline", "result", "certificate", "code"),
    [
        (2.0, "blocked", "confinement", 0),
        (3.9, "undecided", None, 1),
        (4.5, "reachable", "witness", 0),
    ],
)
def test_a_deadline_is_met_or_proved_too_early_or_left_undecided(
    burning, deadline, result, certificate, code
):
    answer = json.loads(run(burning, "--deadline", deadline, "--json").stdout)
    assert (answer["result"], answer["certificate"], answer["deadline"]) == (
        result,
        certificate,
        deadline,
    )
    shown = run(burning, "--deadline", deadline)
    assert shown.exit_code == code and f" within {deadline:g} s" in shown.stdout


def test_under_a_deadline_a_still_world_tells_how_late_the_robot_may_set_out(save):
    answer = json.loads(run(save("w.grid", ROOM), "--deadline", 5, "--json").stdout)
    assert (
        answer["margin"] == pytest.approx(5.0 - 0.2, abs=0.03)
        and answer["latest_start"] >= answer["margin"]
    )
    walled = json.loads(run(save("v.grid", WALLED), "--deadline", 5, "--json").stdout)
    assert (walled["result"], walled["certificate"]) == ("blocked", "cut")


def test_a_deadline_that_is_none_is_refused(save):
    assert isinstance(run(save("w.grid", ROOM), "--deadline", "0").exception, InvalidParameter)
