"""Damaged and hostile files of every format that is read.

A map or one sentence, in bounded time and memory.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.damages import damages
from tests.helpers.foreign_samples import LACKING, READABLE, samples
from worldgen.errors import WorldgenError
from worldgen.interop import find_format, import_world, read_map
from worldgen.interop.format.foreign_map import MAX_CELLS

_LARGEST = 2_000  # largest damaged map, in cells, in which a robot is placed


def read_or_sentence(path, name):
    """Return the map, checked, or the error message."""
    try:
        found = read_map(path, name)
        height, width = found.walls.shape
        assert found.walls.dtype == np.bool_
        assert 0 < height * width <= MAX_CELLS
        assert np.isfinite(found.cell_size) and found.cell_size > 0
        if height * width <= _LARGEST:
            import_world(path, name=name)
        return found
    except WorldgenError as error:
        assert str(error).strip() and "\n" not in str(error)
        return str(error)


def write(folder, files):
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder / next(iter(files))


@pytest.mark.gate
@pytest.mark.parametrize("name", READABLE)
def test_every_format_has_samples_and_they_are_read(name, tmp_path):
    assert samples(name), "add one to tests/helpers/foreign_samples.py"
    for number, files in enumerate(samples(name)):
        path = write(tmp_path / str(number), files)
        assert not isinstance(read_or_sentence(path, name), str)
        assert find_format(path).name == name


@pytest.mark.nightly
@pytest.mark.parametrize("name", READABLE)
@settings(max_examples=15)
@given(st.data())
def test_a_damaged_file_is_read_or_refused_in_one_sentence(name, tmp_path, data):
    files = dict(data.draw(st.sampled_from(samples(name))))
    victim = data.draw(st.sampled_from(list(files)))
    for damage in data.draw(st.lists(damages(), min_size=1, max_size=3)):
        files[victim] = damage(files[victim])
    read_or_sentence(write(tmp_path, files), name)


@pytest.mark.nightly
@pytest.mark.parametrize("name", READABLE)
@settings(max_examples=300)
@given(st.data())
def test_many_damaged_files_are_read_or_refused_in_one_sentence(name, tmp_path, data):
    files = dict(data.draw(st.sampled_from(samples(name))))
    for victim in data.draw(st.lists(st.sampled_from(list(files)), min_size=1, max_size=2)):
        for damage in data.draw(st.lists(damages(), min_size=1, max_size=4)):
            files[victim] = damage(files[victim])
    read_or_sentence(write(tmp_path, files), name)


@pytest.mark.gate
@pytest.mark.parametrize("name", READABLE)
def test_a_file_that_ends_too_early_is_read_or_refused_in_one_sentence(name, tmp_path):
    for files in samples(name)[:1]:
        for victim, whole in files.items():
            for length in sorted({len(whole) * step // 25 for step in range(25)}):
                read_or_sentence(write(tmp_path, {**files, victim: whole[:length]}), name)


@pytest.mark.nightly
@pytest.mark.parametrize("name", READABLE)
def test_a_file_cut_after_any_byte_is_read_or_refused_in_one_sentence(name, tmp_path):
    for files in samples(name)[:2]:
        for victim, whole in files.items():
            for length in range(min(len(whole), 6000)):
                read_or_sentence(write(tmp_path, {**files, victim: whole[:length]}), name)


@pytest.mark.gate
@pytest.mark.parametrize("kib", [128, pytest.param(4096, marks=pytest.mark.nightly)])
def test_hostile_files_are_refused_within_bounds_of_time_and_memory(kib, tmp_path):
    """Run in a process that is limited to 120 s of processor time and 3 GiB of address space."""
    script = Path(__file__).parents[1] / "helpers" / "hostile_files.py"
    command = [sys.executable, str(script), str(tmp_path), str(kib)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    outcomes = json.loads(done.stdout)
    assert [
        one for one in outcomes if not one[2].startswith(("refused: ", "read")) or "\n" in one[2]
    ] == []
    refused = {name for name, _, outcome in outcomes if outcome != "read"}
    assert refused == {*READABLE, *LACKING, "bag"}
