"""What nobody can make the studio do:

run other code, leave its folder, hang, or leave a request without an answer.
"""

import base64
import contextlib
import gzip
import json
import multiprocessing
import os
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib
from dataclasses import replace
from pathlib import Path

import pytest

from fuzz.studio import Folder, Gate
from tests.helpers.raising import raises
from tests.helpers.studio import fitting, free_port, message_of, page_of, studio_of
from tests.helpers.studio_campaign import begin
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import dumps, write_world
from worldgen.interop import export_world
from worldgen.world import FailureRecord, Provenance

FAILURE = Path(__file__).parents[2] / "corpora/thesis-faults/thesis-1-loop-104.grid"
EVIL = """
import pathlib
pathlib.Path(__file__).with_name("pwned").write_text("ran")
"""
ENDS = """
import os


class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        os._exit(3)
"""
HANGS = """
import os
import pathlib


class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        part = pathlib.Path(__file__).with_name("part")
        part.write_text(str(os.getpid()))
        part.rename(part.with_name("hanging"))
        while True:
            pass
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("safety") / "opened"
    folder.mkdir()
    for name, text in (("evil", EVIL), ("ends", ENDS), ("hangs", HANGS)):
        (folder / f"{name}.py").write_text(text)
    write_world(generate("corridor", 3), folder / "w.grid")
    os.mkfifo(folder / "pipe.grid")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder, named=[f"{folder}/ends.py:Robot", f"{folder}/hangs.py:Robot"]) as gate:
        yield gate


@pytest.fixture(scope="module")
def page(gate):
    with page_of(gate) as page:
        yield page


def run_message(**changes):
    usual = {
        "world": message_of(generate("corridor", 3)),
        "motion": "swept",
        "time_step": 0.015,
        "seed": 0,
    }
    return (
        usual
        | {"options": {}, "controllers": ["turn-left"], "steps": 300, "title": "t", "looked": 0}
        | changes
    )


def of_run(**changes):
    return fitting("run", **run_message(**changes))


def until(condition):
    """Wait until a condition holds; fail after a minute."""
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def is_alive(process):
    """Return whether a process exists and is not a zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


# Other code.


@pytest.mark.nightly
@pytest.mark.parametrize("where", ["controller", "oracle", "family"])
def test_a_file_that_names_code_is_opened_and_its_code_is_never_loaded(page, folder, where):
    (folder / "pwned").unlink(missing_ok=True)
    code = f"{folder}/evil.py:Thing"
    record = FailureRecord("turn-left", "swept", 0, "loop", "0" * 16, {"steps": 10})
    if where == "oracle":
        record = replace(record, evidence={"oracle": code, "objection": {}})
    elif where != "family":
        record = replace(record, **{where: code})
    world = replace(generate("corridor", 3), failure=record)
    if where == "family":
        world = replace(world, provenance=Provenance(code, 1, 1, {}))
    (folder / "known").mkdir(exist_ok=True)
    for name in ("f.grid", "known/f.grid"):
        write_world(world, folder / name, force=True)
    drawn = page.ask("open", name="f.grid")["answer"]["world"]
    for do in ("look", "before", "snippet", "know"):
        page.ask(do, **fitting(do, name="f.grid", known=True))
        assert not (folder / "pwned").exists(), do
    for do in ("decide", "measure", "run", "save"):
        given = run_message(world=drawn, name="saved.grid", overwrite=True)
        page.ask(do, **fitting(do, **given))
    page.ask("failures", folder="")
    assert not (folder / "pwned").exists()


@pytest.mark.gate
@pytest.mark.parametrize("do", ["run", "picture"])
def test_no_file_s_code_is_run_as_a_motion_model(page, folder, do):
    said = page.ask(do, **fitting(do, **run_message(motion=f"{folder}/evil.py:Motion", kind="svg")))
    errors = [part["error"] for part in (said, *said.get("parts", ())) if "error" in part]
    assert [error["code"] for error in errors] == ["not-registered"]
    assert not (folder / "pwned").exists()


# The folder.


@pytest.mark.gate
@pytest.mark.parametrize("do", ["open", "look", "save", "bring"])
def test_a_pipe_in_the_folder_is_not_waited_for(page, do):
    message = {"name": "pipe.grid", "world": message_of(generate("corridor", 3)), "overwrite": True}
    assert page.ask(do, **fitting(do, **message))["error"]["code"] == "wrong-kind-of-file"


def test_a_name_too_long_for_the_disk_is_refused_in_a_sentence(folder):
    with raises(InvalidParameter, "name-too-long"):
        Folder(folder).place("x" * 300)


@pytest.mark.gate
def test_an_export_s_companions_lead_no_further_than_itself(page, folder):
    (folder.parent / "secret.pgm").write_text("mine")
    (folder / "map.pgm").symlink_to(folder.parent / "secret.pgm")
    message = {"name": "map.yaml", "format": "ros", "keep": True, "overwrite": True}
    said = page.ask("export", world=message_of(generate("corridor", 3)), **message)
    assert said["error"]["code"] == "outside-of-folder"
    assert (folder.parent / "secret.pgm").read_text() == "mine"


@pytest.mark.parametrize("companion", ["plan.map.worldgen.grid", "plan.map.scen", "plan.scen"])
def test_a_map_s_companions_lead_no_further_than_itself(page, folder, companion):
    (folder.parent / "secret.toml").write_text("secret = 1")
    (folder / "plan.map").write_bytes(
        export_world(generate("corridor", 3), "movingai", file="plan.map").data
    )
    (folder / companion).symlink_to(folder.parent / "secret.toml")
    said = page.ask("bring", name="plan.map")
    (folder / companion).unlink()
    assert (said["error"]["code"], said["error"]["facts"]) == (
        "outside-of-folder",
        {"name": companion},
    )


def test_data_that_are_no_base64_are_the_message_s_fault(page):
    assert (
        page.ask("bring", files=[{"name": "a.txt", "data": "%%%"}])["error"]["code"]
        == "wrong-message"
    )


# The disk, and misleading files.


def png_of(side):
    """Return a picture with this many pixels a side, in a few bytes."""

    def part(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + part(b"IHDR", head)
        + part(b"IDAT", zlib.compress(bytes(side)))
        + part(b"IEND", b"")
    )


HUGE = {
    "zeros.grid.gz": gzip.compress(bytes(100 << 20)),
    "cells.grid.gz": gzip.compress(
        b"%worldgen-grid 1\ncell_size = 0.1\n%cells\n" + b"#" * (60 << 20)
    ),
    "a.png": png_of(40_000),
    "a.pgm": b"P5\n100000 100000\n255\n\0\0",
    "a.npy": b"\x93NUMPY\1\0v\0"
    + b"{'descr': '|u1', 'fortran_order': False, 'shape': (100000, 100000), }".ljust(117)
    + b"\n",
    "a.json": b"[" * 1_000_000,
    "a.map": b"type octile\nheight 50000\nwidth 50000\nmap\n....",
    "a.world": b'<!DOCTYPE sdf [<!ENTITY a "aaaaaaaaaa"><!ENTITY b '
    b'"&a;&a;&a;&a;&a;&a;&a;&a;">]><sdf>&b;</sdf>',
}


@pytest.mark.nightly
@pytest.mark.parametrize("dropped", [False, True])
@pytest.mark.parametrize("name", HUGE)
def test_a_small_file_that_says_it_is_huge_is_refused_in_little_memory(page, folder, name, dropped):
    if dropped:
        said = page.ask(
            "bring", files=[{"name": name, "data": base64.b64encode(HUGE[name]).decode()}]
        )
    else:
        (folder / name).write_bytes(HUGE[name])
        said = page.ask("open" if ".grid" in name else "bring", name=name)
    assert said["error"]["source"] == name and name not in said["error"]["problem"]
    assert said["error"]["code"] != "our-fault"
    assert most_memory() < 700 << 20


def most_memory():
    """Memory of any process of the studio, at any time, in bytes."""
    told = [
        Path(f"/proc/{worker.pid}/status").read_text()
        for worker in multiprocessing.active_children()
    ]
    return max(1024 * int(re.search(r"VmHWM:\s+(\d+)", one)[1]) for one in told)


@contextlib.contextmanager
def no_room(bytes_left):
    """The studio's processes must not write anything longer."""
    for worker in multiprocessing.active_children():
        resource.prlimit(worker.pid, resource.RLIMIT_FSIZE, (bytes_left, resource.RLIM_INFINITY))
    try:
        yield
    finally:
        for worker in multiprocessing.active_children():
            resource.prlimit(
                worker.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
            )


@pytest.mark.parametrize("do", ["save", "export", "bring"])
def test_a_full_disk_is_told_and_nothing_is_left_half_written(page, folder, do):
    drawn, large = (message_of(generate("corridor", 3, size=size)) for size in (30, 100))
    page.ask("save", name="room.grid", world=drawn, overwrite=True)
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    message = {"name": "room.grid", "world": large, "overwrite": True}
    if do == "export":
        message |= {"name": "new.yaml", "format": "ros", "keep": True}
    if do == "bring":
        message = {"files": [{"name": "a.txt", "data": base64.b64encode(b"#" * 5000).decode()}]}
    with no_room(3000):
        said = page.ask(do, **fitting(do, **message))
    assert "File too large" in said["error"]["problem"] and said["error"]["code"] != "our-fault"
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before
    assert page.ask("open", name="room.grid")["answer"]["world"]["cells"] == drawn["cells"]


@contextlib.contextmanager
def read_only(folder):
    """A read-only folder."""
    if os.geteuid() != 0:
        folder.chmod(0o555)
    elif subprocess.run(
        ["mount", "--bind", "-o", "ro", folder, folder], check=False, capture_output=True
    ).returncode:
        pytest.skip("root writes everywhere here")
    try:
        yield
    finally:
        if os.geteuid() != 0:
            folder.chmod(0o755)
        else:
            subprocess.run(["umount", folder], check=True)


@pytest.mark.nightly
@pytest.mark.parametrize("do", ["save", "export", "begin", "know"])
def test_a_folder_that_nobody_can_write_is_read_and_what_is_written_is_refused(do, tmp_path):
    shutil.copy(FAILURE, tmp_path / "f.grid")
    message = {
        "name": "f.grid",
        "world": message_of(generate("corridor", 3)),
        "overwrite": True,
        "known": True,
    }
    message |= {
        "format": "thesis",
        "keep": True,
        "folder": "c",
        "controller": "turn-left",
        "motion": "swept",
    }
    if do == "export":
        message |= {"name": "f.gex"}
    with read_only(tmp_path), studio_of(tmp_path) as gate, page_of(gate) as page:
        assert page.ask("open", name="f.grid")["answer"]["world"]["cells"]
        said = page.ask(do, **fitting(do, strategies=[], units=1, **message))
    assert re.search("Read-only|Permission denied", said["error"]["problem"])
    assert str(tmp_path) not in json.dumps(said["error"])
    assert [path.name for path in tmp_path.iterdir()] == ["f.grid"]


# Every request is answered.


def test_a_message_too_deep_to_hand_on_is_answered(page):
    page.socket.send('{"id":700,"do":"files","x":' + "[" * 970 + "]" * 970 + "}")
    assert page.hear()["error"]


@pytest.mark.nightly
def test_a_controller_that_ends_its_process_is_told_and_the_next_one_runs(page, folder):
    said = page.ask("run", **of_run(controllers=[f"{folder}/ends.py:Robot"]))
    assert said["error"]["code"] == "process-died"
    assert page.ask("run", **of_run())["parts"][-1]["verdict"]


@pytest.mark.nightly
@pytest.mark.parametrize("text", ["while True: pass", "import time\nwhile True: time.sleep(0.1)"])
def test_a_controller_that_is_never_done_loading_is_named_and_ended_with_its_page(text, tmp_path):
    file = tmp_path / "never.py"
    file.write_text(text)
    with studio_of(tmp_path, named=[f"{file}:Robot"]) as gate:
        with page_of(gate) as page:
            page.send("hello")
            assert page.hear()["part"] == f"{file}:Robot"
        file.write_text("")
        with page_of(gate) as page:
            (named,) = (one for one in page.ask("hello")["answer"]["controllers"] if one["named"])
    assert named["fault"]["code"] == "unknown-name"


@pytest.mark.nightly
def test_a_picture_of_a_controller_that_hangs_is_ended_with_its_page(gate, folder):
    with page_of(gate) as page:
        (folder / "hanging").unlink(missing_ok=True)
        page.send("picture", **run_message(kind="svg", controllers=[f"{folder}/hangs.py:Robot"]))
        until((folder / "hanging").exists)
    with page_of(gate) as page:
        assert page.ask("picture", **run_message(kind="svg"))["answer"]


@pytest.mark.nightly
def test_a_campaign_runs_no_code_of_files_that_lie_in_its_folder(page, folder):
    (folder / "pwned").unlink(missing_ok=True)
    record = FailureRecord("turn-right", "motion", 0, "loop", "0" * 16, {"steps": 10})
    text = dumps(replace(generate("corridor", 3), failure=record)).decode()
    assert text.count('"motion"') == 1
    (folder / "found").mkdir()
    for name in ("found/f.grid", "known/g.grid"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text.replace('"motion"', f'"{folder}/evil.py:Motion"'))
    begin(page, "found", units=1, known=True)
    begin(page, "found", units=1)
    page.ask("stop", folder="found")
    assert not (folder / "pwned").exists()


@pytest.mark.gate
@pytest.mark.parametrize("do", ["watch", "stop", "resume"])
def test_a_campaign_s_memory_is_neither_a_link_nor_does_it_hold_a_pipe(page, folder, tmp_path, do):
    memories = [folder / name / ".campaign" for name in ("linked", "piped")]
    for memory in memories:
        memory.parent.mkdir(exist_ok=True)
    memories[0].unlink(missing_ok=True)
    memories[0].symlink_to(tmp_path)
    memories[1].mkdir(exist_ok=True)
    (memories[1] / "studio.txt").unlink(missing_ok=True)
    os.mkfifo(memories[1] / "studio.txt")
    for name in ("linked", "piped"):
        assert page.ask(do, folder=name)["error"]["code"] == "not-a-campaign-folder"


@pytest.mark.nightly
def test_a_controller_that_hangs_is_gone_with_a_server_that_was_killed(folder):
    port = free_port()
    command = [
        sys.executable,
        "-m",
        "worldgen",
        "studio",
        str(folder),
        "--no-browser",
        "--port",
        str(port),
    ]
    (folder / "hanging").unlink(missing_ok=True)
    command += ["--controller", f"{folder}/hangs.py:Robot"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        token = server.stderr.readline().split("token=")[1].strip()
        with page_of(Gate("127.0.0.1", port, token)) as page:
            page.send("run", **of_run(controllers=[f"{folder}/hangs.py:Robot"]))
            until((folder / "hanging").exists)
            server.send_signal(signal.SIGKILL)
    until(lambda: not is_alive(int((folder / "hanging").read_text())))


@pytest.mark.gate
def test_ctrl_c_while_processes_begin_ends_the_studio_without_a_word(folder):
    command = [
        sys.executable,
        "-m",
        "worldgen",
        "studio",
        str(folder),
        "--no-browser",
        "--port",
        "0",
    ]
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as server:
        port, token = re.search(r":(\d+)/\?token=(.*)", server.stderr.readline()).groups()
        with page_of(Gate("127.0.0.1", int(port), token)) as page:
            for do in ("files", "decide", "run", "campaigns", "failures", "picture"):
                page.send(do, **fitting(do, folder="", **run_message(kind="svg")))
            page.ask("nothing")  # the others are about to start
            os.killpg(server.pid, signal.SIGINT)  # as a terminal does
            _, said = server.communicate(timeout=60)
    said = said.replace(
        "Press Ctrl-C to stop. Saved worlds stay.\n", ""
    )  # somebody may have read it with the address
    assert (server.returncode, said) == (0, "")
