"""The studio's server: its answers, and who gets them."""

import asyncio
import base64
import gzip
import io
import json
import multiprocessing
import threading
import zipfile

import msgspec
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from fuzz.studio import Folder
from fuzz.studio.catalogue import catalogue
from fuzz.studio.requests.limits import MOST_MESSAGE
from fuzz.studio.requests.messages import restored, world_of
from fuzz.studio.requests.protocol import Files, Limits, decoded
from fuzz.studio.workers import Worker
from sim.episode import simulate
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from tests.helpers.studio import fitting, get, message_of, page_of, received, sent, studio_of
from worldgen import generate
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.files.grid import dumps, read_world, write_world
from worldgen.interop import export_world
from worldgen.world import Pose, Target, World

CONTROLLER = """
class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return (0.0, 1.0), memory
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = (
        tmp_path_factory.mktemp("studio") / "opened"
    )  # its parent is out of bounds, and so is its own path
    folder.mkdir()
    (folder.parent / "secret.grid").write_bytes(dumps(generate("trap", 1)))
    (folder / "out.grid").symlink_to(folder.parent / "secret.grid")
    (folder / "outside").symlink_to(folder.parent)
    (folder / "mine.py").write_text(CONTROLLER)
    write_world(generate("corridor", 3), folder / "w.grid")
    write_world(generate("fire", 3), folder / "fire.grid")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder, named=[f"{folder}/mine.py:Robot"], file="w.grid") as gate:
        yield gate


@pytest.fixture(scope="module")
def page(gate):
    with page_of(gate) as page:
        yield page


def refused(gate, **how):
    """Return the status with which a connection is refused."""
    with pytest.raises(InvalidStatus) as caught, page_of(gate, **how):
        pass
    return caught.value.response.status_code


def world(**changes):
    return message_of(generate("corridor", 3)) | changes


def run_message(**changes):
    usual = {"world": world(), "motion": "swept", "time_step": 0.015, "seed": 0, "options": {}}
    return usual | {"controllers": ["turn-left"], "steps": 300} | changes


# Access control.


def test_the_address_with_the_token_gives_a_cookie_that_other_sites_cannot_send(gate):
    answer = get(gate, f"/?token={gate.token}", token=False)
    cookie = answer.headers["set-cookie"]
    assert answer.status == 200 and gate.cookie_value in cookie and gate.token not in cookie
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie


@pytest.mark.parametrize(
    "path", ["/", "/?token=", "/?token=wrong", "/studio/start.js", "/player/map.js", "/nowhere"]
)
def test_nobody_gets_anything_without_the_token(gate, path):
    answer = get(gate, path, token=False)
    assert answer.status == 403 and b"your browser has no access" in answer.body


@pytest.mark.parametrize(
    "host", ["evil.example:{port}", "evil.example", "127.0.0.1", "127.0.0.1:1", "10.0.0.1:{port}"]
)
def test_a_name_that_was_made_to_lead_here_is_refused(gate, host):
    assert get(gate, Host=host.format(port=gate.port)).status == 421


@pytest.mark.parametrize(
    "headers",
    [{"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec_Fetch_Site": "cross-site"}],
)
def test_a_request_of_another_site_is_refused_though_the_browser_knows_the_cookie(gate, headers):
    assert get(gate, "/studio/start.js", **headers).status == 403


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_is_done_over_http(gate, method):
    assert get(gate, method=method).status == 405


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "", "https://127.0.0.1"])
def test_a_connection_of_another_site_or_of_none_is_refused(gate, origin):
    assert refused(gate, origin=origin) == 403


def test_a_connection_under_a_name_that_was_made_to_lead_here_is_refused(gate):
    host = f"evil.example:{gate.port}"
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
    key = {"Sec_WebSocket_Key": base64.b64encode(b"0" * 16).decode()}
    assert get(gate, "/socket", Host=host, Origin=f"http://{host}", **upgrade, **key).status == 403


def test_a_connection_without_the_cookie_is_refused(gate):
    assert refused(gate, cookie=False) == 403


def test_a_server_of_another_port_that_the_browser_shows_the_cookie_cannot_connect_with_it(gate):
    assert refused(gate, token=False) == 403


def test_the_address_that_a_browser_is_started_with_lets_in_once(gate):
    path = "/?ticket=" + gate.address_for_once().rpartition("=")[2]
    first, second = (get(gate, path, token=False) for _ in range(2))
    assert (first.status, first.headers["location"]) == (303, gate.address)
    assert second.status == 403 and "set-cookie" not in first.headers


@pytest.mark.parametrize(
    "path", ["/../answers.py", "/studio/../gate.py", "/studio/%2e%2e/gate.py", "/player/", "/x"]
)
def test_the_server_gives_the_page_s_parts_and_nothing_else(gate, path):
    assert get(gate, path).status == 404


def test_the_page_travels_compressed(gate):
    plain, packed = get(gate), get(gate, Accept_Encoding="gzip")
    assert gzip.decompress(packed.body) == plain.body
    assert len(packed.body) < len(plain.body) / 3


def test_every_answer_forbids_scripts_in_the_page_s_text_and_everything_from_elsewhere(gate):
    for answer in (get(gate), get(gate, token=False), get(gate, "/nowhere")):
        policy = answer.headers["content-security-policy"]
        assert (
            "default-src 'none'" in policy
            and "script-src 'nonce-" in policy
            and "unsafe" not in policy.replace("'wasm-unsafe-eval'", "")
        )
        assert answer.headers["x-content-type-options"] == "nosniff"


# The folder.


@pytest.mark.parametrize(
    "name",
    ["../secret.grid", "/etc/passwd", "out.grid", "outside/secret.grid", "a/../../secret.grid", ".hidden", "", "a//b",
     "a\\..\\b", "C:x", "a\0b", "x" * 1000, "./w.grid", "sub/.git/config"],
)  # fmt: skip
def test_no_name_leads_out_of_the_folder(folder, name):
    with pytest.raises(InvalidParameter, match=r"the (opened )?folder"):
        Folder(folder).place(name)


def test_links_hidden_files_and_what_is_no_map_are_not_listed(folder):
    assert [file.name for file in Folder(folder).files((".map",))] == ["fire.grid", "w.grid"]
    assert "mine.py" in [file.name for file in Folder(folder).files((".py",))]


@pytest.mark.gate
@pytest.mark.parametrize("do", ["open", "save", "bring", "export"])
def test_no_question_leads_out_of_the_folder(page, folder, do):
    given = {"name": "outside/new.grid", "world": world(), "overwrite": True, "keep": True}
    said = page.ask(do, **fitting(do, format="thesis", **given))
    assert said["error"]["code"] == "outside-of-folder"
    assert not (folder.parent / "new.grid").exists()


@pytest.mark.gate
def test_a_file_is_overwritten_only_if_that_is_asked_for(page, folder):
    error = page.ask("save", name="w.grid", world=world(), overwrite=False)["error"]
    assert (error["code"], error["facts"]["path"], error["terminal"]) == (
        "file-exists",
        "w.grid",
        False,
    )


# What is answered.


def test_it_says_first_what_is_open(page, folder):
    assert page.begins == {
        "protocol": 4,
        "folder": str(folder),
        "file": "w.grid",
        "limits": sent(Limits()),
    }


@pytest.mark.gate
def test_it_offers_what_is_registered_and_what_was_named(page, folder):
    offered = page.ask("hello")["answer"]
    assert offered["controllers"][0]["name"] == f"{folder}/mine.py:Robot"
    assert {"maze", "trap"} <= {family["name"] for family in offered["families"]}
    assert next(motion for motion in offered["motions"] if motion["name"] == "stepped")["thesis"]


def test_a_named_controller_stands_first_with_the_motion_model_it_drives_in():
    labels = ["thesis-1+repaired+motion=stepped", "bug1"]
    offered = sent(catalogue(labels, print).controllers)
    assert [(one["name"], one["motion"]) for one in offered if one["named"]] == list(
        zip(labels, ["stepped", "swept"], strict=True)
    )
    assert [one["name"] for one in offered[:2]] == labels


@pytest.mark.gate
def test_a_controller_that_took_long_to_fail_is_tried_again_when_its_file_is_mended(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("fuzz.studio.catalogue._SLOW", -1.0)
    (tmp_path / "mine.py").write_text(f"print('tried')\nraise OSError({'x' * 50!r})\n")
    label = f"{tmp_path / 'mine.py'}:Robot"
    first, again = (sent(catalogue([label], print).controllers)[0] for _ in range(2))
    assert first["fault"] and again["fault"] == first["fault"]
    (tmp_path / "mine.py").write_text(CONTROLLER)
    assert not sent(catalogue([label], print).controllers)[0]["fault"]


def test_a_robot_s_second_name_is_told():
    also = {one["name"]: one["also"] for one in sent(catalogue([], print).controllers)}
    assert (also["thesis-1"], also["turn-right"], also["bug1"]) == ("turn-right", "thesis-1", "")


@pytest.mark.gate
def test_a_world_saved_as_it_was_opened_is_the_same_file(page, folder):
    opened = page.ask("open", name="fire.grid")["answer"]["world"]
    page.ask("save", name="same.grid", world=opened, overwrite=True)
    assert (folder / "same.grid").read_bytes() == (folder / "fire.grid").read_bytes()
    (folder / "same.grid").unlink()


def test_an_edited_world_is_saved_with_a_proof_of_its_own(page, folder):
    opened = page.ask("open", name="w.grid")["answer"]["world"]
    page.ask("save", name="sub.grid", world=opened | {"robot_radius": 0.05}, overwrite=True)
    saved = read_world(folder / "sub.grid")
    assert saved.provenance is None and saved.certificate.clearance >= 0.05
    (folder / "sub.grid").unlink()


@pytest.mark.gate
def test_a_proof_comes_with_its_way_or_its_cut(page):
    free = page.ask("decide", world=world())["answer"]
    wide = page.ask("decide", world=world(robot_radius=1.0))["answer"]
    assert free["result"] == "reachable" and "witness" in free
    assert wide["result"] == "blocked" and wide["cut"]


@pytest.mark.nightly
def test_the_widest_robot_just_passes(page):
    widest = page.ask("widest", world=world())["answer"]
    assert (
        page.ask("decide", world=world(robot_radius=widest * (1 - 1e-6)))["answer"]["result"]
        == "reachable"
    )
    wider = widest * (1 + 1e-6)
    assert page.ask("decide", world=world(robot_radius=wider))["answer"]["result"] == "blocked"


@pytest.mark.gate
def test_a_generated_world_is_the_command_line_s(page):
    made = page.ask("generate", family="maze", seed="7", parameters={"size": 20})["answer"]
    assert made["world"]["source"] == dumps(generate("maze", 7, size=20)).decode()


@pytest.mark.nightly
def test_a_run_is_the_library_s_to_the_digest(page):
    said = page.ask("run", **run_message(controllers=["turn-left", "turn-right"]))
    digests = [part["digest"] for part in said["parts"] if "digest" in part]
    wanted = [
        simulate(generate("corridor", 3), name, steps=300).trace_digest
        for name in ("turn-left", "turn-right")
    ]
    assert digests == wanted


@pytest.mark.gate
def test_a_controller_named_at_the_start_may_run_and_its_fault_is_told(page, folder):
    said = page.ask("run", **run_message(controllers=[f"{folder}/mine.py:Robot", "turn-left"]))
    assert ["error" in part or part["verdict"] for part in said["parts"][1:]][1]
    assert len(said["parts"]) == 3


@pytest.mark.gate
@pytest.mark.parametrize(
    "name", ["./mine.py:Robot", "cmd:touch gone", "os:system", "fuzz.studio:Gate"]
)
def test_no_other_controller_runs(page, name):
    (_, part) = page.ask("run", **run_message(controllers=[name]))["parts"]
    assert part["error"]["code"] == "not-named"


@pytest.mark.gate
@pytest.mark.parametrize(
    ("do", "message"), [("generate", {"family": "./mine.py:Robot"}), ("bring", {"format": "./x:y"})]
)
def test_no_file_s_code_is_run_as_a_family_or_format(page, do, message):
    given = {"seed": "1", "parameters": {}, "name": "w.grid"} | message
    said = page.ask(do, **fitting(do, **given))
    assert said["error"]["code"] == "not-registered"


DRAWING = "\n".join(
    [
        "#" * 12,
        "#S" + "." * 9 + "#",
        *["#" + "." * 10 + "#"] * 8,
        "#" + "." * 9 + "G#",
        "#" * 12,
        "",
    ]
)


def test_a_dropped_map_becomes_a_world_and_is_exported_as_the_command_line_does(page, folder):
    data = base64.b64encode(DRAWING.encode()).decode()
    brought = page.ask("bring", files=[{"name": "../../drawing.txt", "data": data}])["answer"][
        "world"
    ]
    (made,) = page.ask("export", name="d.gex", world=brought, format="thesis", keep=False)[
        "answer"
    ]["files"]
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(made["data"]))) as archive:
        data = archive.read("d.gex")
    assert data == export_world(restored(received(brought)), "thesis", file="d.gex").data


def test_what_is_wrong_with_a_dropped_file_is_said_by_its_own_name(page):
    data = base64.b64encode(b"##\n#?\n").decode()
    assert (
        page.ask("bring", files=[{"name": "../drawing.txt", "data": data}])["error"]["source"]
        == "drawing.txt"
    )


def test_a_document_type_in_a_dropped_file_is_said_once(page):
    data = base64.b64encode(b"<?xml version='1.0'?><!DOCTYPE sdf><sdf version='1.7'/>").decode()
    error = page.ask("bring", files=[{"name": "e.world", "data": data}])["error"]
    assert (error["source"], error["line"]) == ("e.world", 1)
    assert (
        error["problem"].startswith("a document type ('sdf') is declared")
        and "/" not in error["problem"]
    )


@pytest.mark.gate
def test_a_newer_question_replaces_an_older_one(gate):
    with page_of(gate) as page:
        first = page.send("decide", world=world())
        second = page.send("decide", world=world())
        said = {one["id"]: one for one in (page.hear(), page.hear())}
    assert "answer" in said[second] and first in said


@pytest.mark.nightly
def test_what_was_left_of_a_replaced_run_is_not_taken_for_the_next(gate):
    with page_of(gate) as page:
        page.send("run", **run_message(controllers=["turn-left"] * 6, steps=20_000))
        page.hear()
        last = page.send("run", **run_message(controllers=["turn-right"]))
        said = iter(page.hear, {"id": last, "answer": None})
        names = [one["part"].get("name") for one in said if one["id"] == last]
    assert names == [None, "turn-right"]


@pytest.mark.nightly
def test_a_run_that_nobody_wants_is_ended_and_the_next_one_runs(gate, folder):
    with page_of(gate) as page:
        hanging = page.send(
            "run", **run_message(steps=1_000_000, controllers=[f"{folder}/mine.py:Robot"])
        )
        threading.Event().wait(0.3)
        page.send("cancel", of=hanging)
        ended = [page.hear() for _ in range(2)]
        again = page.ask("run", **run_message())
    assert {"id": hanging, "ended": True} in ended or any("part" in said for said in ended)
    assert again["parts"][-1]["verdict"]


@pytest.mark.parametrize("more", [{}, {"difficulty": 0.5}])
@pytest.mark.parametrize("name", ["seed", "tries", "progress"])
def test_what_is_no_parameter_of_a_family_is_told(page, name, more):
    said = page.ask("generate", family="trap", seed="1", parameters={name: 3}, **more)
    assert f"trap has no option '{name}'" in said["error"]["problem"]


def test_half_of_a_character_is_the_message_s_fault(page):
    page.send("save", name="x.grid", overwrite=True, world=world(source="\ud800"))
    said = page.hear()
    assert said["error"]["code"] == "not-json"


@pytest.mark.parametrize(
    "text", [b"{}", "", "{", "[]", "1", '{"id": 1}', '{"id": -1, "do": '
                                                     '"files"}', '{"id": true, "do": "files"}',
             "[" * 100_000, '{"id": 7, "do": "__init__"}', '{"id": 8, "do": "open"}',
             '{"id": 9, "do": "open", "name": 3}', '{"id": 10, "do": "files", "more": 1}'],
)  # fmt: skip
def test_nonsense_gets_a_sentence(page, text):
    page.socket.send(text)
    assert page.hear()["error"]


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        ({"do": "watch", "folder": 3}, "folder = 3: Expected `str`, got `int`"),
        ({"do": "picture", "motion": "x", "time_step": 1, "seed": 0, "options": {}, "looked": -1},
         "looked = -1: Expected `int` >= 0"),
        ({"do": "files", "more": 1}, "the page's message: Object contains unknown field `more`"),
        ({"do": "files", "id": 2**53}, f"id = {2**53}: Expected `int` <= {2**53 - 1}"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_message_is_said_by_field_value_and_rule(message, problem):
    with raises(InvalidParameter, "wrong-message") as caught:
        decoded(json.dumps({"id": 1} | message))
    assert caught.value.message.problem == problem


def test_the_rule_that_a_message_breaks_quotes_little_of_it():
    with raises(InvalidParameter, "wrong-message") as caught:
        decoded(json.dumps({"id": 1, "do": "x" * 100_000}))
    assert len(caught.value.message.problem) < 500


def test_a_message_larger_than_allowed_ends_the_connection(gate):
    with pytest.raises(ConnectionClosed), page_of(gate) as page:
        page.socket.send(json.dumps({"id": 1, "do": "files", "x": "x" * (33 << 20)}))
        page.hear()


@pytest.mark.parametrize(
    "changes",
    [{"width": 0}, {"width": 1 << 20, "height": 1 << 20}, {"cells": "%"}, {"cells": ""}, {"start": [1.0]},
     {"cell_size": "a"}, {"events": []}, {"robot_radius": True},
     {"events": {"times": [0.0], "ix": [], "iy": [], "state": []}}],
)  # fmt: skip
def test_a_message_that_is_no_world_is_refused(changes):
    with pytest.raises((msgspec.ValidationError, InvalidParameter, InvalidWorld)):
        world_of(received(world(**changes)))


def test_a_world_with_changes_comes_back_from_its_message():
    burning = generate("fire", 3)
    assert restored(received(message_of(burning))) == burning


def test_a_world_of_several_robots_keeps_them_whatever_is_drawn():
    world = generate("doorway", 1, robots=3)
    message = message_of(world)
    assert restored(received(message)) == world
    # After an edit, the first robot is the drawn one, and the others stay.
    edited = restored(received({**message, "robot_speed": 1.0}))
    assert edited.robot_speed == 1.0 and edited.robots[1:] == world.robots[1:]
    assert edited.certificate is None
    # A robot drawn onto another one is an error, not a loss.
    x, y = world.robots[1].start.x, world.robots[1].start.y
    with raises(InvalidWorld, "robots-overlap"):
        restored(received({**message, "start": [x, y, 0.0]}))
    with raises(InvalidWorld, "other-robots", robots=3):
        restored(
            received(message_of(generate("doorway", 1, size=20)) | {"source": message["source"]})
        )


def test_a_world_whose_lengths_the_page_would_round_to_nothing_is_refused_in_words():
    tiny = World(
        np.zeros((3, 3), np.bool_),
        Pose(1e-6, 1e-6, 0.0),
        Target(2e-6, 2e-6, 1e-7),
        cell_size=1e-6,
        robot_radius=1e-7,
    )
    with raises(InvalidWorld, "out-of-range"):
        message_of(tiny)


def test_a_port_that_is_taken_is_told(gate, tmp_path):
    said = worldgen("studio", tmp_path, "--no-browser", "--port", gate.port)
    assert said.code == 2 and said.error_code == "port-taken"


def test_a_message_that_is_too_large_ends_that_connection_alone(gate):
    with page_of(gate) as page, page_of(gate) as other:
        with pytest.raises(ConnectionClosed) as closed:
            page.ask("open", name="x" * MOST_MESSAGE)
        assert closed.value.rcvd.code == 1009
        assert "answer" in other.ask("files")


def test_what_is_wrong_with_a_name_is_said_without_the_path_of_the_folder(page, folder):
    message = {"world": message_of(generate("corridor", 3)), "overwrite": False}
    for said in (
        page.ask("save", name="missing/w.grid", **message),
        page.ask("open", name="missing.grid"),
    ):
        assert "missing" in json.dumps(said["error"]) and str(folder) not in json.dumps(
            said["error"]
        )


def test_a_worker_that_waits_holds_no_other_up(tmp_path, monkeypatch):
    ends = []

    def start(worker):
        ours, theirs = multiprocessing.Pipe()
        ends.append((ours, theirs))
        return ours

    async def ask(worker):
        return [said async for said in worker.ask(Files(id=0))][-1]

    async def all_wait_but_one():
        workers = [Worker(Folder(tmp_path), ()) for _ in range(40)]
        tasks = [asyncio.create_task(ask(worker)) for worker in workers]
        while len(ends) < len(workers):
            await asyncio.sleep(0.01)
        ends[-1][1].send(("answer", "here", {}))
        try:
            return await asyncio.wait_for(tasks[-1], 20)
        finally:
            for _, theirs in ends:
                theirs.close()
            await asyncio.wait(tasks)

    monkeypatch.setattr(Worker, "_start", start)
    assert asyncio.run(all_wait_but_one()) == ("answer", "here", {})


def test_the_signal_is_the_one_that_the_thesis_s_robot_reads(page):
    plain, noisy = (
        page.ask("signal", world=world(), noise=noise)["answer"] for noise in (False, True)
    )
    assert plain != noisy


@pytest.mark.gate
def test_a_world_that_meets_a_constraint_is_searched_for_and_measured(page):
    said = page.ask(
        "generate", family="trap", seed="1", parameters={"size": 20}, where="detour > 1.2"
    )
    metrics = page.ask("measure", world=said["answer"]["world"])["answer"]
    assert next(metric["value"] for metric in metrics if metric["name"] == "detour") > 1.2
    assert said["parts"][-1]["done"] == len(said["parts"])
