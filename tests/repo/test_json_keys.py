"""The keys of ``--json`` that scripts rely on; new ones may be added, these stay."""

import json

import pytest

from tests.helpers.command_line import worldgen

KEYS = {
    "verify": {"result", "certificate_valid", "clearance", "radius"},
    "run": {"verdict", "steps", "time", "path_length", "collisions", "trace_digest", "evidence"},
    "audit": {"ok", "findings"},
    "fuzz": {"seed", "worlds", "steps", "seconds", "times", "failures", "hazards"},
    "replay": {"replayed", "confirmed", "failures"},
}
FAILURE = {
    "fuzz": {"file", "verdict", "class", "solid_cells", "replay"},
    "replay": {"file", "verdict", "confirmed"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys")
    assert worldgen("trap", "--seed", 1, "--out", folder / "w.grid").code == 0
    worldgen("run", folder / "w.grid", "--controller", "turn-right", "--trace", folder / "t.csv")
    return folder


@pytest.fixture(scope="module")
def answers(folder):
    """The output of each command; the replayed failures are the campaign's."""
    world = folder / "w.grid"
    found = folder / "found"
    search = (
        "--controller",
        "turn-right",
        "--strategy",
        "native",
        "--examples",
        1,
        "--units",
        1,
        "--seed",
        1,
    )
    commands = {
        "verify": (world,),
        "run": (world, "--controller", "turn-right"),
        "audit": (world, folder / "t.csv"),
        "fuzz": (*search, "--no-shrink", "--workers", 1, "--out", found),
        "replay": (found,),
    }
    return {
        name: json.loads(worldgen(name, *more, "--json").out) for name, more in commands.items()
    }


@pytest.mark.parametrize("command", KEYS)
def test_json_has_the_keys_that_scripts_rely_on(command, answers):
    assert KEYS[command] <= set(answers[command])


@pytest.mark.parametrize("command", FAILURE)
def test_each_failure_has_the_keys_that_scripts_rely_on(command, answers):
    failures = answers[command]["failures"]
    assert failures and all(FAILURE[command] <= set(one) for one in failures)
