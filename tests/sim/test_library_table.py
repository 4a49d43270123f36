"""The table of how often each controller arrives."""

import json
import re
import sys

import pytest

from benchmarks import library
from sim import simulate
from worldgen import generate
from worldgen.family import FAMILIES


def printed(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["library", *words])
    library.main()
    return capsys.readouterr().out


def test_it_has_each_controller_once_and_by_one_name():
    names = library.controllers()
    assert len(names) == 28 and {"bug1", "vfh", "thesis-1"} < set(names)


def test_a_row_counts_every_run_and_measures_those_that_arrived():
    worlds = [generate("trap", seed) for seed in range(4)]
    (bug, left) = library.rows_of(worlds, ["bug2", "wall-left"], 20_000)
    ways = sorted(
        simulate(world, "bug2").path_length / world.certificate.length for world in worlds
    )
    assert bug.verdicts["reached"] == 4 and bug.detour == pytest.approx((ways[1] + ways[2]) / 2)
    assert sum(left.verdicts.values()) == 4 and left.verdicts["loop"] > 0


@pytest.mark.gate
def test_it_prints_a_table_for_the_corpus_and_for_every_family(monkeypatch, capsys):
    out = printed(monkeypatch, capsys, "--worlds", "1", "--steps", "300", "--controller", "bug2")
    alone = [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
    assert re.findall(r"^(\S+), (\d+) worlds?:$", out, flags=re.MULTILINE) == [
        ("corpora/thesis", "10"),
        *((name, "1") for name in alone),
    ]


@pytest.mark.nightly
def test_as_json_it_says_the_same_each_time(monkeypatch, capsys):
    words = ("--worlds", "2", "--steps", "300", "--controller", "bug2", "--json")
    first, second = (json.loads(printed(monkeypatch, capsys, *words)) for _ in range(2))
    assert first == second and sum(first["tables"]["maze"][0]["verdicts"].values()) == 2
