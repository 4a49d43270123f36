"""Families: every seed yields the same bytes as when its digest was stored.

``tests/data/family_digests.json`` holds a digest of the layouts of 200 seeds for each family and
many of its parameters. If a family's layouts change on purpose, raise its version and store its
digests again.
"""

import hashlib
import json
from pathlib import Path

import pytest

from worldgen.family import FAMILIES, stream_for
from worldgen.files.grid.writer import world_digest

SEEDS = 200
STORED = json.loads(
    (Path(__file__).parents[1] / "data" / "family_digests.json").read_text(encoding="utf-8")
)


def parameters(family, words):
    """Return a family's parameters from ``name=value``, with defaults for the rest."""
    types = {parameter.name: type(parameter.default) for parameter in family.parameters}
    given = dict(word.split("=", 1) for word in words)
    return family.complete({name: types[name](value) for name, value in given.items()})


@pytest.mark.nightly
@pytest.mark.parametrize("case", STORED)
def test_seeds_yield_the_bytes_that_they_always_yielded(case):
    name, *words = case.split(" ")
    family = FAMILIES.get(name)
    params = parameters(family, words)
    digest = hashlib.sha256()
    for seed in range(SEEDS):
        world = family.build(stream_for(seed, name, 0), **params)
        digest.update(world_digest(world).encode())
    assert digest.hexdigest() == STORED[case]
