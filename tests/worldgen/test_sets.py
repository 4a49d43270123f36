"""Sets of worlds: interrupted sets continue, finished worlds are kept, and a manifest recreates the
set.
"""

import hashlib
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import tarfile
import time
import zipfile

import pytest

import worldgen.files.locks
import worldgen.sets.stores
from tests.helpers.command_line import worldgen as run
from tests.helpers.raising import raises
from tests.helpers.set_contents import contents
from worldgen.difficulty import with_metrics
from worldgen.errors import FormatError, OutputError
from worldgen.files.archives import members
from worldgen.files.grid import dumps, read_world, world_digest
from worldgen.generation import generate
from worldgen.sets import SetDifference, check_set, make_set, manifest_of, plan_set, regenerate_set
from worldgen.sets.journal import Journal
from worldgen.sets.manifest import ManifestEntry, parse_manifest

SMALL = {"size": 12}
TRAPS = ("trap", "--size", 12, "--seed", 5, "--count", 6)
OWN = """
from worldgen import Pose, Target, World
from worldgen.family import family

@family("pillars", version=1)
def pillars(rng, *, size: int = 12):
    \"""A room with a pillar.\"""
    walls = [[x in (0, size - 1) or y in (0, size - 1) for x in range(size)] for y in range(size)]
    walls[rng.between(4, 7)][rng.between(4, 7)] = True
    return World(walls, start=Pose(0.2, 0.2), target=Target(1.0, 1.0, 0.05))
"""
every_kind = pytest.mark.parametrize("out", ["set", "set.zip"])
TARS = {"set.tar.gz": "w:gz", "set.tar.bz2": "w:bz2"}  # only read
read_kinds = pytest.mark.parametrize("out", ["set", "set.zip", *TARS])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with the set of traps in each form, never interrupted; tests must not change it."""
    folder = tmp_path_factory.mktemp("whole")
    for out in ("set", "set.zip"):
        assert run(*TRAPS, "--out", folder / out).code == 0
    for out, mode in TARS.items():
        with tarfile.open(folder / out, mode) as archive:
            for file in sorted((folder / "set").iterdir()):
                archive.add(file, file.name)
    return folder


@pytest.fixture
def traps(whole, tmp_path):
    """A copy of the set's folder."""
    return shutil.copytree(whole / "set", tmp_path / "set")


def test_a_manifest_says_of_each_world_what_it_is(whole):
    lines = [json.loads(line) for line in (whole / "set/manifest.jsonl").read_text().splitlines()]
    assert (
        lines[0]["format"] == "worldgen-set 1" and lines[0]["count"] == 6 and lines[0]["seed"] == 5
    )
    for seed, line in enumerate(lines[1:], 5):
        world = with_metrics(generate("trap", seed, size=12))
        assert line["metrics"] == world.provenance.metrics
        assert line["digest"] == world_digest(world) and line["params"] == {}
        assert lines[0]["params"] == dict(world.provenance.params)
        assert (line["family"], line["version"], line["seed"]) == (
            "trap",
            world.provenance.version,
            seed,
        )
        assert (whole / "set" / line["file"]).read_bytes() == dumps(world) and line["bytes"] == len(
            dumps(world)
        )


def test_a_manifest_whose_lines_repeat_every_parameter_is_read_and_made_again(whole, tmp_path):
    folder = whole / "set"
    first, *lines = [
        json.loads(line) for line in (folder / "manifest.jsonl").read_text().splitlines()
    ]
    full = [first, *({**line, "params": first["params"]} for line in lines)]
    (tmp_path / "manifest.jsonl").write_text("".join(f"{json.dumps(line)}\n" for line in full))
    assert manifest_of(tmp_path).entries == manifest_of(folder).entries
    assert run("regenerate", tmp_path).code == 0
    for file in folder.glob("*.grid"):
        assert (tmp_path / file.name).read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    ("value", "own"),
    [(0.0, {}), (-0.0, {"braid": -0.0}), (0, {"braid": 0}), (False, {"braid": False})],
)
def test_a_line_says_only_of_parameters_that_differ_and_keeps_their_types(value, own):
    header = plan_set("maze", seed=0, count=1, params={"braid": 0.0}).header
    params = {**header.params, "braid": value}
    line = ManifestEntry("m.grid", "maze", 1, 0, params, "0" * 64, "0" * 64, 9, {}).line(header)
    assert repr(json.loads(line)["params"]) == repr(own)
    [entry] = parse_manifest([header.line(), line], "text").entries
    assert {name: repr(read) for name, read in entry.params.items()} == {
        name: repr(v) for name, v in params.items()
    }


@read_kinds
def test_an_archive_holds_what_the_folder_does(whole, out):
    if out != "set":
        held = {member.name: member.read(1 << 20) for member in members(whole / out)}
        assert held == contents(whole / "set")


@pytest.mark.gate
@pytest.mark.parametrize("out", ["set", "set.zip"])
def test_equal_commands_make_equal_bytes_with_any_workers(whole, tmp_path, out):
    make_set(plan_set("trap", 5, 6, SMALL), tmp_path / out, workers=3)
    assert contents(tmp_path / out) == contents(whole / out)


@every_kind
def test_a_set_is_made_again_from_its_manifest_byte_for_byte(whole, tmp_path, out):
    manifest = shutil.copy(whole / "set/manifest.jsonl", tmp_path / "kept.jsonl")
    assert run("regenerate", manifest, "--out", tmp_path / out).code == 0
    assert contents(tmp_path / out) == contents(whole / out)


@read_kinds
def test_every_set_is_what_its_manifest_says(whole, out):
    result = run("regenerate", whole / out, "--check", "--json")
    assert result.code == 0 and json.loads(result.out)["differences"] == []


@pytest.mark.nightly
@pytest.mark.skipif(os.name == "nt", reason="sends SIGKILL")
@pytest.mark.parametrize("out", ["set", "set.zip"])
def test_a_set_that_is_killed_and_gone_on_with_is_the_same_bytes(tmp_path, out):
    command = ["maze", "--seed", 1, "--count", 60, "--out", tmp_path / out]
    manifest = tmp_path / (out if out == "set" else out + ".part") / "manifest.jsonl"
    for lines in (3, 20):
        process = subprocess.Popen(
            [sys.executable, "-m", "worldgen", *map(str, command)], stderr=subprocess.DEVNULL
        )
        while not manifest.is_file() or manifest.read_bytes().count(b"\n") < lines:
            assert process.poll() is None
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert "worlds already exist; continuing" in run(*command).err
    run(*command[:-1], tmp_path / f"whole-{out}")
    assert contents(tmp_path / out) == contents(tmp_path / f"whole-{out}")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([out, f"whole-{out}"])


@pytest.mark.gate
@pytest.mark.skipif(os.name == "nt", reason="sends SIGKILL")
def test_workers_of_a_command_that_is_killed_end_too(tmp_path):
    command = ["maze", "--seed", 1, "--count", 5000, "--out", tmp_path / "set"]
    process = subprocess.Popen(
        [sys.executable, "-m", "worldgen", *map(str, command)], stderr=subprocess.PIPE
    )
    while not (tmp_path / "set/manifest.jsonl").is_file():
        assert process.poll() is None
        time.sleep(0.01)
    process.kill()
    process.communicate(timeout=180)  # until no process holds the other end of its stderr


@pytest.mark.parametrize("torn", [1, 30, 700], ids="{} bytes short".format)
def test_a_torn_manifest_goes_on_from_its_last_whole_line(whole, traps, torn):
    manifest = traps / "manifest.jsonl"
    manifest.write_bytes(manifest.read_bytes()[:-torn])
    assert run(*TRAPS, "--out", traps).code == 0
    assert contents(traps) == contents(whole / "set")


def test_a_manifest_torn_in_its_first_line_begins_anew(whole, tmp_path):
    (tmp_path / "set").mkdir()
    (tmp_path / "set/manifest.jsonl").write_bytes(b'{"format": "worldg')
    assert run(*TRAPS, "--out", tmp_path / "set").code == 0
    assert contents(tmp_path / "set") == contents(whole / "set")


@pytest.mark.parametrize("left", [None, b""], ids=["gone", "empty"])
def test_a_file_that_a_power_cut_took_is_made_again(whole, traps, left):
    lines = (traps / "manifest.jsonl").read_bytes().splitlines(keepends=True)
    (traps / "manifest.jsonl").write_bytes(b"".join(lines[:5]))
    (traps / "trap-7.grid").unlink() if left is None else (traps / "trap-7.grid").write_bytes(left)
    assert run(*TRAPS, "--out", traps).code == 0
    assert contents(traps) == contents(whole / "set")


def test_a_world_that_an_unpacked_archive_lost_is_made_again(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(worldgen.sets.stores.SetArchive, "finish", lambda self: None)
    run(*TRAPS, "--out", tmp_path / "set.zip")
    monkeypatch.undo()
    (tmp_path / "set.zip.part/trap-8.grid").unlink()
    assert (
        "3 of 6 worlds already exist; continuing" in run(*TRAPS, "--out", tmp_path / "set.zip").err
    )
    assert contents(tmp_path / "set.zip") == contents(whole / "set.zip")


def test_a_drawn_seed_is_taken_up_again(drawn_seeds, tmp_path):
    options = ("trap", "--size", 12, "--count", 4, "--out", tmp_path / "set")
    seed = run(*options).err.split()[1]
    manifest = tmp_path / "set/manifest.jsonl"
    manifest.write_bytes(b"".join(manifest.read_bytes().splitlines(keepends=True)[:3]))
    assert run(*options).err.startswith(f"seed {seed}\n")
    assert len(manifest_of(tmp_path / "set").entries) == 4


@pytest.mark.parametrize(
    ("other", "lines", "error_code"),
    [
        ({}, 7, "set-finished"),
        ({"--shape": "V"}, 4, "other-set"),
        ({"--count": 7}, 7, "other-set"),
        ({"--seed": 6}, 7, "other-set"),
    ],
    ids=["finished", "unfinished", "longer", "elsewhere"],
)
def test_what_is_there_is_not_replaced_unasked(traps, other, lines, error_code):
    manifest = traps / "manifest.jsonl"
    manifest.write_bytes(b"".join(manifest.read_bytes().splitlines(keepends=True)[:lines]))
    before = contents(traps)
    options = dict(zip(TRAPS[1::2], TRAPS[2::2], strict=True)) | other
    result = run("trap", *itertools.chain(*options.items()), "--out", traps)
    assert result.code == 2 and result.error_code == error_code and contents(traps) == before


def test_an_archive_that_is_there_is_not_replaced_unasked(tmp_path):
    (tmp_path / "set.zip").write_text("mine")
    result = run(*TRAPS, "--out", tmp_path / "set.zip")
    assert result.code == 2 and result.error_code == "file-exists"
    assert (tmp_path / "set.zip").read_text() == "mine"


def test_force_replaces_the_files_of_a_set_and_no_others(traps):
    (traps / "notes.txt").write_text("mine")
    assert run("maze", "--size", 12, "--seed", 1, "--count", 2, "--out", traps, "--force").code == 0
    assert sorted(contents(traps)) == ["manifest.jsonl", "maze-1.grid", "maze-2.grid", "notes.txt"]


def test_force_with_bad_parameters_replaces_nothing(traps, whole):
    assert run("maze", "--size", 5, "--count", 2, "--out", traps, "--force").code == 2
    assert contents(traps) == contents(whole / "set")


def test_a_file_that_a_person_changed_stays(traps):
    manifest = traps / "manifest.jsonl"
    manifest.write_bytes(manifest.read_bytes()[:-1])
    (traps / "trap-6.grid").write_text("mine")
    result = run(*TRAPS, "--out", traps)
    assert result.code == 2 and result.error_code == "other-content"
    assert (traps / "trap-6.grid").read_text() == "mine"


@pytest.mark.skipif(os.name == "nt", reason="no file locks")
def test_two_commands_do_not_write_one_set(traps):
    other = Journal(traps / "manifest.jsonl")
    other.read()
    assert run(*TRAPS, "--out", traps).error_code == "written-meanwhile"
    other.close()
    assert run(*TRAPS, "--out", traps).error_code == "set-finished"


@pytest.mark.skipif(os.name == "nt", reason="no file locks")
def test_no_other_command_begins_in_a_folder_that_is_being_removed(tmp_path, monkeypatch):
    remove, refused = shutil.rmtree, []

    def remove_watched(part, **options):
        with raises(OutputError, "written-meanwhile"):
            Journal(part / "manifest.jsonl").read(force=True)
        refused.append(part)
        remove(part, **options)

    monkeypatch.setattr(worldgen.sets.stores.shutil, "rmtree", remove_watched)
    make_set(plan_set("trap", 5, 1, SMALL), tmp_path / "set.zip")
    assert refused == [tmp_path / "set.zip.part"] and not refused[0].exists()


@pytest.mark.skipif(os.name == "nt", reason="no file locks")
def test_a_manifest_that_is_removed_before_it_is_locked_is_not_written(traps, monkeypatch):
    manifest = traps / "manifest.jsonl"
    monkeypatch.setattr(worldgen.files.locks.fcntl, "flock", lambda *_: manifest.unlink())
    with raises(OutputError, "written-meanwhile"):
        Journal(manifest).read()


@pytest.mark.parametrize("out", ["set", "set.zip"])
def test_a_set_that_came_into_being_meanwhile_is_not_replaced(tmp_path, out):
    place = tmp_path / out

    def another_works_meanwhile(done):
        make_set(plan_set("trap", 5, 2, SMALL), place)

    with raises(OutputError, "written-meanwhile"):
        make_set(plan_set("maze", 1, 1, SMALL), place, progress=another_works_meanwhile)
    assert check_set(place, manifest_of(place)) == [] and len(manifest_of(place).entries) == 2
    assert not (tmp_path / "set.zip.part").exists()


@pytest.mark.gate
@pytest.mark.parametrize(
    ("out", "way_out"), [("set", "without --force continues"), ("set.zip", "set.zip is moved away")]
)
def test_what_force_began_goes_on_as_the_message_says(whole, tmp_path, monkeypatch, out, way_out):
    place = tmp_path / out
    run("maze", "--size", 12, "--seed", 1, "--count", 2, "--out", place)
    real = Journal.append
    monkeypatch.setattr(
        Journal, "append", lambda self, line: full() if b"trap-8" in line else real(self, line)
    )
    result = run(*TRAPS, "--out", place, "--force")
    assert result.code == 2 and way_out in result.err
    monkeypatch.undo()
    if place.is_file():
        place.rename(tmp_path / "moved.zip")
    assert "3 of 6 worlds already exist" in run(*TRAPS, "--out", place).err
    assert contents(place) == contents(whole / out)


def full():
    raise OutputError("unwritable", "No space left on device")


def test_a_file_that_an_archive_has_twice_is_found(whole, tmp_path):
    with (
        zipfile.ZipFile(shutil.copy(whole / "set.zip", tmp_path), "a") as archive,
        pytest.warns(UserWarning),
    ):
        archive.writestr("trap-7.grid", b"another")
    assert check_set(tmp_path / "set.zip", manifest_of(whole / "set")) == [
        SetDifference("extra", "trap-7.grid")
    ]


def test_an_archive_of_another_compression_is_refused(whole, tmp_path):
    with zipfile.ZipFile(tmp_path / "lzma.zip", "w", zipfile.ZIP_LZMA) as archive:
        archive.write(whole / "set/trap-7.grid", "trap-7.grid")
    result = run("verify", tmp_path / "lzma.zip")
    assert result.code == 2 and result.error_code == "unsupported"


def test_a_full_disk_loses_nothing_and_the_command_goes_on(whole, tmp_path, monkeypatch):
    real = worldgen.sets.stores.place_file

    def full(file, data):
        if file.name == "trap-8.grid":
            raise OSError(28, "No space left on device")
        real(file, data)

    monkeypatch.setattr(worldgen.sets.stores, "place_file", full)
    result = run(*TRAPS, "--out", tmp_path / "set")
    assert (
        result.code == 2
        and "3 of 6 worlds are written; the same command continues from there" in result.err
    )
    assert result.error_code == "unwritable"
    monkeypatch.undo()
    run(*TRAPS, "--out", tmp_path / "set")
    assert contents(tmp_path / "set") == contents(whole / "set")


@pytest.mark.parametrize("out", ["set", "set.zip"])
def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path, out):
    (tmp_path / "file").write_text("")
    result = run(*TRAPS, "--out", tmp_path / "file" / out)
    assert result.code == 2 and "Traceback" not in result.err and result.error_code == "unwritable"


def damage(folder, kind):
    if kind == "missing":
        (folder / "trap-7.grid").unlink()
    elif kind == "changed":
        (folder / "trap-7.grid").write_bytes(
            (folder / "trap-7.grid").read_bytes().replace(b"#", b".", 1)
        )
    elif kind == "extra":
        (folder / "sub").mkdir()
        (folder / "sub/trap-7.grid").write_text("")
    else:
        lines = (folder / "manifest.jsonl").read_bytes().splitlines(keepends=True)
        (folder / "manifest.jsonl").write_bytes(b"".join(lines[:6]))
        (folder / "trap-10.grid").unlink()


@pytest.mark.parametrize(
    ("kind", "file"),
    [
        ("missing", "trap-7.grid"),
        ("changed", "trap-7.grid"),
        ("extra", "sub/trap-7.grid"),
        ("unfinished", "manifest.jsonl"),
    ],
)
def test_every_kind_of_difference_is_found(traps, kind, file):
    damage(traps, kind)
    result = run("regenerate", traps, "--check", "--json")
    assert result.code == 1 and json.loads(result.out)["differences"] == [
        {"kind": kind, "file": file}
    ]


def test_a_set_elsewhere_is_checked_against_a_manifest(whole, traps):
    damage(traps, "changed")
    result = run("regenerate", whole / "set/manifest.jsonl", "--out", traps, "--check")
    assert result.code == 1 and result.out == f"{traps / 'trap-7.grid'}: changed\n"


def test_an_archive_is_checked_file_by_file(whole, traps, tmp_path):
    damage(traps, "changed")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(traps)
        shutil.make_archive(str(tmp_path / "packed"), "zip", ".")
    assert [
        str(found.kind) for found in check_set(tmp_path / "packed.zip", manifest_of(whole / "set"))
    ] == ["changed"]


def test_what_is_missing_is_made_again_beside_its_manifest(whole, traps):
    damage(traps, "missing")
    result = run("regenerate", traps)
    assert (
        result.code == 0
        and "1 worlds made, 5 already existed" in result.err
        and contents(traps) == contents(whole / "set")
    )


def test_what_was_changed_is_made_again_only_with_force(whole, traps):
    damage(traps, "changed")
    assert run("regenerate", traps).error_code == "other-content"
    assert run("regenerate", traps, "--force").code == 0 and contents(traps) == contents(
        whole / "set"
    )


def edited(whole, tmp_path, old, new):
    text = (whole / "set/manifest.jsonl").read_text().replace(old, new)
    (tmp_path / "manifest.jsonl").write_text(text)
    return tmp_path / "manifest.jsonl"


def test_a_family_of_another_version_is_refused(whole, tmp_path):
    version = generate("trap").provenance.version
    manifest = edited(whole, tmp_path, f'"version": {version}', f'"version": {version + 1}')
    result = run("regenerate", manifest, "--out", tmp_path / "again")
    assert result.code == 2 and result.error_code == "other-version"
    assert not (tmp_path / "again").exists()


def test_a_world_that_comes_out_otherwise_is_told_and_not_written(whole, tmp_path):
    sha256 = manifest_of(whole / "set").entries[2].sha256
    manifest = edited(whole, tmp_path, sha256, "0" * 64)
    result = run("regenerate", manifest, "--out", tmp_path / "again")
    assert result.code == 1 and "trap-7.grid is different this time" in result.err
    assert not (tmp_path / "again/trap-7.grid").exists()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "worldgen-set 1",
            "worldgen-set 9",
            {"code": "wrong-value", "key": "format", "value": '"worldgen-set 9"'},
        ),
        (
            '"file": "trap-7.grid"',
            '"file": "../../trap-7.grid"',
            {"code": "wrong-value", "key": "file"},
        ),
        (
            '"file": "trap-7.grid"',
            '"file": "trap-6.grid"',
            {"code": "twice", "file": "trap-6.grid"},
        ),
        ('"seed": 7', '"seed": "7"', {"code": "wrong-value", "key": "seed", "value": '"7"'}),
        ('"seed": 7, ', "", {"code": "missing-key", "key": "seed"}),
        ('"seed": 7', f'"seed": {2**64}', {"code": "wrong-value", "key": "seed"}),
        ('"count": 6', f'"count": {2**70}', {"code": "wrong-value", "key": "count"}),
        (
            '"version": ',
            '"version": 9223372036854775808',
            {"code": "wrong-value", "key": "version"},
        ),
        (
            '"metrics": ',
            '"constraint": 3, "metrics": ',
            {"code": "wrong-value", "key": "constraint"},
        ),
        ('{"file": "trap-7.grid"', "[", {"code": "not-json"}),
        ('"count": 6', '"count": 5', {"code": "wrong-count", "worlds": 6}),
    ],
)
def test_a_manifest_with_a_fault_is_refused_with_its_line(whole, tmp_path, old, new, expected):
    with raises(FormatError, **expected):
        manifest_of(edited(whole, tmp_path, old, new))


def test_a_manifest_with_an_unknown_parameter_is_refused_before_anything_is_made(whole, tmp_path):
    manifest = edited(whole, tmp_path, '"params": {}', '"params": {"seed": 5}')
    result = run("regenerate", manifest, "--out", tmp_path / "o")
    assert (
        result.code == 2 and result.error_code == "unknown-name" and not (tmp_path / "o").exists()
    )


def test_a_familys_own_file_is_named_again(tmp_path):
    (tmp_path / "mine.py").write_text(OWN)
    place = f"{tmp_path}/mine.py:pillars"
    run(place, "--count", 2, "--seed", 1, "--out", tmp_path / "set")
    assert run("regenerate", tmp_path / "set", "--out", "x").error_code == "unknown-name"
    again = run("regenerate", tmp_path / "set", "--family", place, "--out", tmp_path / "again")
    assert again.code == 0 and contents(tmp_path / "again") == contents(tmp_path / "set")


def test_a_set_without_metrics_is_made_again_without(tmp_path):
    run(*TRAPS, "--no-metrics", "--out", tmp_path / "set")
    assert "metrics" not in (tmp_path / "set/trap-5.grid").read_text()
    run("regenerate", tmp_path / "set", "--out", tmp_path / "again")
    assert contents(tmp_path / "again") == contents(tmp_path / "set")


def test_a_manifest_from_before_a_parameter_was_added_gives_the_same_bytes(whole, tmp_path):
    text = (whole / "set/manifest.jsonl").read_text().replace('"angle": 0, ', "")
    for seed in range(5, 11):
        old = (whole / f"set/trap-{seed}.grid").read_bytes()
        new = old.replace(b"angle = 0, ", b"")
        text = text.replace(hashlib.sha256(old).hexdigest(), hashlib.sha256(new).hexdigest())
    (tmp_path / "manifest.jsonl").write_text(text)
    result = run("regenerate", tmp_path / "manifest.jsonl", "--out", tmp_path / "again")
    assert result.code == 0 and b"angle" not in (tmp_path / "again/trap-7.grid").read_bytes()


@every_kind
def test_commands_read_sets_in_every_form(whole, out):
    result = json.loads(run("verify", whole / out, "--json").out)
    assert sorted(found["path"] for found in result["files"]) == sorted(
        str(whole / out / f"trap-{seed}.grid") for seed in range(5, 11)
    )
    assert all(found["certificate_valid"] for found in result["files"])
    assert read_world(whole / out / "trap-7.grid") == with_metrics(generate("trap", 7, size=12))


@pytest.mark.parametrize("out", TARS)
def test_a_set_in_a_tar_file_is_read_and_never_written(whole, tmp_path, out):
    assert run("verify", whole / out).code == 0
    result = run(*TRAPS, "--out", tmp_path / out)
    assert result.code == 2 and result.error_code == "unknown-format"
    assert "ends in .zip" in result.err and not list(tmp_path.iterdir())


def test_a_file_that_an_archive_lacks_is_one_sentence(whole):
    result = run("show", whole / "set.zip/trap-99.grid")
    assert result.code == 2 and result.error_code == "no-such-file"


@pytest.mark.parametrize("out", ["set.zip", "set.tar.gz", "set.tar.bz2"])
@pytest.mark.parametrize("end", [100, -700], ids=["head", "most"])
def test_an_archive_that_is_cut_off_is_one_sentence(whole, tmp_path, out, end):
    (tmp_path / out).write_bytes((whole / out).read_bytes()[:end])
    result = run("verify", tmp_path / out)
    assert result.code == 2 and "copy it again" in result.err
    assert len(result.err.splitlines()) <= 3 and "a bug in worldgen" not in result.err


def test_json_tells_of_a_set(tmp_path):
    told = json.loads(run(*TRAPS, "--out", tmp_path / "set.zip", "--json").out)
    assert (told["count"], told["seed"], told["resumed"], told["out"]) == (
        6,
        5,
        0,
        str(tmp_path / "set.zip"),
    )
    assert (
        told["files"][1]["file"] == str(tmp_path / "set.zip/trap-6.grid")
        and told["files"][1]["seed"] == 6
    )


def test_from_python_a_set_tells_how_far_it_is(whole, tmp_path):
    seen = []
    plan = plan_set("trap", 5, 6, SMALL)
    make_set(plan, tmp_path / "set", progress=seen.append)
    assert seen == list(range(7)) and contents(tmp_path / "set") == contents(whole / "set")
    with raises(OutputError, "set-finished"):
        regenerate_set(manifest_of(tmp_path / "set"), tmp_path / "set")
