"""Contents of the studio's campaign page that are not separate files:

failures in archives, worlds of behaviours.
"""

import json
import shlex
import shutil

import pytest

from fuzz.failure import Failure
from sim import simulate
from tests.helpers.command_line import worldgen
from tests.helpers.studio import page_of
from tests.helpers.studio_packed import FAILURES, PACKERS, fill, pack_zip, studio_with_kinds
from worldgen.files.grid import read_world
from worldgen.world import World

pytestmark = pytest.mark.nightly  # their shared fixture takes half a minute


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packed")
    fill(folder)
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_with_kinds(folder) as gate:
        yield gate


@pytest.fixture(scope="module")
def asked(gate):
    with page_of(gate) as asked:
        yield asked


def failures(asked, folder):
    return asked.ask("failures", folder=folder)["answer"]


def test_failures_have_their_place_in_the_order_of_failures(asked):
    told = sorted(failures(asked, "plain")["failures"], key=lambda one: one["place"])
    ordered = sorted(FAILURES, key=lambda path: Failure.read(path).order)
    digests = [Failure.read(path).digest for path in ordered]
    assert [one["digest"] for one in told] == digests


def test_archives_are_offered_beside_folders(asked):
    said = asked.ask("campaigns")["answer"]
    assert said["archives"] == list(PACKERS)
    assert not {one["name"] for one in said["folders"]} & set(said["archives"])


@pytest.mark.parametrize("name", PACKERS)
def test_an_archive_holds_the_failures_that_its_folder_held(asked, name):
    packed, plain = failures(asked, name), failures(asked, "plain")
    assert packed["faults"] == [] and len(packed["failures"]) == len(FAILURES)
    assert sorted(one["digest"] for one in packed["failures"]) == sorted(
        one["digest"] for one in plain["failures"]
    )
    assert {one["name"] for one in packed["failures"]} == {
        f"{name}/deep/{file.name}" for file in FAILURES
    }


@pytest.mark.parametrize("name", PACKERS)
def test_a_failure_in_an_archive_is_looked_at_opened_replayed_and_copied(asked, folder, name):
    one = failures(asked, name)["failures"][0]["name"]
    seen = asked.ask("look", name=one)["answer"]
    assert seen["run"]["steps"] > 0
    program, *words = shlex.split(seen["replay"])
    assert program == "worldgen" and worldgen(*words).code == 0
    answer = asked.ask("open", name=one)["answer"]
    assert answer["failure"]["controller"] == "turn-right" and answer["file"] is None
    assert "FAILURE" in asked.ask("snippet", name=one)["answer"]


def test_a_failure_in_an_archive_is_marked_as_known_by_a_copy(asked, folder):
    one = failures(asked, "old.zip")["failures"][0]
    assert "answer" in asked.ask("know", name=one["name"], known=True)
    again = failures(asked, "old.zip")["failures"]
    assert [other["name"] for other in again if other["known"]] == [one["name"]]
    shutil.rmtree(folder / "known")


def test_what_cannot_be_read_in_an_archive_is_told_and_hides_nothing_else(asked, folder):
    good = FAILURES[0].read_bytes()
    pack_zip(
        folder / "bad.zip",
        {"ok.grid": good, "cut.grid": good[:90], "../out.grid": good}
        | {f"{where}/w.grid": good for where in ("", folder)},
    )
    said = failures(asked, "bad.zip")
    assert [one["name"] for one in said["failures"]] == ["bad.zip/ok.grid"]
    assert len(said["faults"]) == 4 and "bad.zip/cut.grid" in [
        fault["source"] for fault in said["faults"]
    ]
    pack_zip(
        folder / "bad.zip",
        {"ok.grid": good, ".campaign/seen/a.grid": good, "__MACOSX/._ok.grid": b"no world"},
    )
    said = failures(asked, "bad.zip")
    assert [one["name"] for one in said["failures"]] == ["bad.zip/ok.grid"] and not said["faults"]
    (folder / "bad.zip").write_bytes((folder / "old.zip").read_bytes()[:500])
    (fault,) = failures(asked, "bad.zip")["faults"]
    assert fault["source"] == "bad.zip"
    (folder / "bad.zip").unlink()


def test_each_kind_of_the_archive_opens_the_world_that_it_tells_of(asked, folder):
    cells = json.loads((folder / "kinds/.campaign/summary.json").read_text())["archive"]["cells"]
    assert len(cells) > 5
    for i, j, quality, verdict in cells[:: len(cells) // 5]:
        answer = asked.ask("elite", folder="kinds", i=i, j=j)["answer"]
        saved = asked.ask("save", name="elite.grid", world=answer["world"], overwrite=True)[
            "answer"
        ]
        world: World = read_world(folder / saved["name"])
        assert world.solid_cells == -quality
        runs = answer["runs"]
        assert (runs["controller"], runs["motion"]) == ("turn-right", "swept")
        assert simulate(world, "turn-right").verdict == verdict
    (folder / "elite.grid").unlink()


@pytest.mark.parametrize(
    ("place", "i", "why"),
    [("kinds", 10_000, "empty-cell"), ("plain", 0, "empty-cell"), ("../x", 0, "outside-of-folder")],
)
def test_a_kind_that_nobody_has_met_is_told(asked, place, i, why):
    assert asked.ask("elite", folder=place, i=i, j=0)["error"]["code"] == why
