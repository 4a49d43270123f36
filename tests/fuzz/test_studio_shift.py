"""The worlds in which the studio can let walls change places."""

from dataclasses import replace
from pathlib import Path

import pytest

from fuzz.studio.requests.messages import world_of
from tests.helpers.studio import message_of, page_of, received, studio_of
from worldgen.families.builtin.shift import shifted
from worldgen.files.grid import read_world

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("play")
    (folder / "config-05.grid").write_bytes(CONFIG_5.read_bytes())
    with studio_of(folder, file="config-05.grid") as gate:
        yield gate


@pytest.mark.gate
@pytest.mark.parametrize("seed", ["-1", "x", "9" * 5000, "0" * 5000])
def test_a_seed_that_is_none_is_refused(gate, seed):
    with page_of(gate) as page:
        assert (
            page.ask("shift", world=message_of(read_world(CONFIG_5)), seed=seed)["error"]["code"]
            == "wrong-message"
        )


@pytest.mark.gate
def test_a_world_that_is_not_square_or_changes_already_is_not_shifted(gate):
    still = read_world(CONFIG_5)
    with page_of(gate) as page:
        flat = message_of(
            replace(still, walls=still.walls[:, :-1], certificate=None, provenance=None)
        )
        assert "no mirror image" in page.ask("shift", world=flat, seed="0")["error"]["problem"]
        moving = page.ask("shift", world=message_of(still), seed="7")["answer"]
        assert world_of(received(moving)) == shifted(still, 7)
        assert "already changes" in page.ask("shift", world=moving, seed="0")["error"]["problem"]
        empty = message_of(
            replace(still, walls=still.walls & still.walls.T[::-1, ::-1], certificate=None)
        )
        assert "free mirror image" in page.ask("shift", world=empty, seed="0")["error"]["problem"]
