"""How the studio starts: its host and port, its arguments, and the controllers that it knows."""

import asyncio
import errno
import json
import re
import signal
import socket
import subprocess
import sys
import tomllib
from collections import defaultdict
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

import pytest
from starlette.datastructures import Headers
from starlette.websockets import WebSocketDisconnect
from websockets.exceptions import ConnectionClosed

from fuzz.studio import Gate
from fuzz.studio.app import FULL
from fuzz.studio.serving import USUAL_PORT, bind, called
from fuzz.studio.session import Session
from fuzz.studio.starting import check_controller
from tests.helpers.command_line import worldgen
from tests.helpers.studio import page_of, studio_of
from worldgen.errors import InvalidParameter
from worldgen.plugins.installation import pip_install


def test_it_listens_to_this_machine_alone_unless_told():
    gate = Gate("127.0.0.1", 80)
    assert gate.knows_host("localhost:80") and not gate.knows_host("192.168.1.2:80")


def test_at_the_port_that_browsers_leave_out_it_knows_its_name_without():
    assert Gate("127.0.0.1", 80).knows_host("127.0.0.1") and Gate("::1", 80).knows_host("[::1]")
    assert not Gate("127.0.0.1", 80).knows_host("evil.example") and not Gate("::1", 81).knows_host(
        "[::1]"
    )


@pytest.mark.parametrize(
    ("host", "name"),
    [("127.1", "127.0.0.1"), ("0:0::1", "::1"), ("LOCALHOST", "localhost"), ("", "0.0.0.0")],
)
def test_a_host_is_known_by_what_a_browser_makes_of_it(host, name):
    with bind(host, None) as listener:
        assert called(host, listener) == name


@pytest.mark.parametrize("host", ["a\0b", "x" * 80, "a host", "::x"])
def test_what_can_be_no_host_is_told(host):
    with pytest.raises(InvalidParameter, match="choose another --host"):
        bind(host, None)


def test_bound_to_every_address_it_still_knows_no_name_but_its_own():
    gate = Gate("0.0.0.0", 80)
    assert gate.knows_host("192.168.1.2:80") and not gate.knows_host("evil.example:80")


def test_a_cookie_that_is_none_lets_nobody_in():
    gate = Gate("127.0.0.1", 80)
    assert not any(
        gate.has_cookie(Headers({"cookie": text}))
        for text in ("", "=", "\x00", f"other={gate.token}", "[]")
    )


def test_two_studios_have_two_tokens():
    assert Gate("127.0.0.1", 80).token != Gate("127.0.0.1", 80).token


def test_of_two_studios_that_start_at_once_the_second_takes_another_port(monkeypatch):
    class Late(socket.socket):
        def listen(self, *backlog):
            if (
                self.getsockname()[1] == usual
            ):  # the other one is also bound to it, and started listening first
                raise OSError(errno.EADDRINUSE, "taken")
            super().listen(*backlog)

    with bind("127.0.0.1", 0) as free:
        usual = free.getsockname()[1]
    monkeypatch.setattr("fuzz.studio.serving.USUAL_PORT", usual)
    monkeypatch.setattr("fuzz.studio.serving.socket.socket", Late)
    with bind("127.0.0.1", None) as listener:
        assert listener.getsockname()[1] != usual


def test_a_process_that_cannot_begin_ahead_of_time_costs_no_connection():
    class Full:
        def warm(self):
            raise OSError(errno.EAGAIN, "too many processes")

        async def ask(self, request):
            yield "answer", None, {}

    class Socket:
        def __init__(self):
            self.asked, self.said = [json.dumps({"id": 7, "do": "campaigns"})], []

        async def accept(self, name):
            pass

        async def receive_text(self):
            if self.asked:
                return self.asked.pop()
            await asyncio.sleep(0.1)
            raise WebSocketDisconnect

        async def send_text(self, text):
            self.said.append(json.loads(text))

    page = Session(Socket(), defaultdict(Full), {})
    asyncio.run(page.serve())
    assert page.socket.said[1:] == [{"id": 7, "answer": None}]


def test_port_0_is_one_that_is_free():
    with bind("127.0.0.1", 0) as one, bind("127.0.0.1", 0) as other:
        ports = {listener.getsockname()[1] for listener in (one, other)}
        assert len(ports) == 2 and not ports & {0, USUAL_PORT}


@pytest.mark.gate
@pytest.mark.parametrize("quiet", [(), ("--quiet",)])
def test_the_command_prints_the_port_that_it_has_found(tmp_path, quiet):
    command = [
        sys.executable,
        "-m",
        "worldgen",
        "studio",
        str(tmp_path),
        "--no-browser",
        "--port",
        "0",
        *quiet,
    ]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        host, port, token = re.search(
            r"http://(.*):(\d+)/\?token=(.*)", server.stderr.readline()
        ).groups()
        with page_of(Gate(host, int(port), token)) as page:
            assert page.begins["folder"] == str(tmp_path)
        server.send_signal(signal.SIGINT)
        assert server.wait(timeout=60) == 0


def test_a_warning_about_who_can_reach_the_studio_is_printed_with_quiet_too(tmp_path, monkeypatch):
    listener = SimpleNamespace(getsockname=lambda: ("0.0.0.0", 1234))
    monkeypatch.setattr("fuzz.studio.serving.bind", lambda host, port: listener)
    monkeypatch.setattr("fuzz.studio.serving.called", lambda host, listener: "robots.example")
    monkeypatch.setattr("fuzz.studio.serving.serve", lambda *args, **more: None)
    result = worldgen("studio", tmp_path, "--host", "0.0.0.0", "--no-browser", "--quiet")
    assert "warning: anyone who can reach robots.example" in result.err


def test_one_page_more_than_there_may_be_is_closed_with_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz.studio.app.MOST_PAGES", 2)
    with studio_of(tmp_path) as gate, page_of(gate), page_of(gate):
        with pytest.raises(ConnectionClosed) as closed, page_of(gate):
            pass
        assert closed.value.rcvd.code == FULL
        assert (
            closed.value.rcvd.reason == "2 pages are open, which is the limit; close another one."
        )


def test_the_command_says_what_is_wrong_with_its_path(tmp_path):
    assert "no such file" in worldgen("studio", tmp_path / "gone", "--no-browser").err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--controller", "turn-rigt"], "did you mean 'turn-right'?"),
        (["--controller", "nope+noise"], "no controller is called 'nope'"),
        (["--controller", "{}/gone.py:Robot"], "gone.py cannot be read: No such file"),
        (["--controller", "{}/loud.py:Nope"], "has no 'Nope'; its classes: Robot"),
        (["--controller", "{}/junk.grid:Robot"], "there is no module"),
        (["--controller", "{}/torn.py:Robot"], "is not valid Python"),
        (["--controller", "__main__:Robot"], "there is no module __main__"),
        (
            ["--controller", ":Robot"],
            "does not name a module; add it: module:Robot or ./file.py:Robot",
        ),
        (["{}/words.txt"], "words.txt:1: 'h' in column 1 is not a cell"),
        (["{}/junk.grid"], "junk.grid"),
        (["{}/my --words.txt"], "words.txt:1: 'h' in column 1 is not a cell"),
        (["{}/set.zip"], "set.zip is an archive of worlds; open its folder"),
        (["--host", "192.0.2.1", "--port", "8000"], "192.0.2.1 is not an address of this machine"),
        (["--host", "192.0.2.1"], "192.0.2.1 is not an address of this machine"),
    ],
)
def test_the_studio_does_not_start_with_arguments_that_are_wrong(tmp_path, arguments, words):
    (tmp_path / "loud.py").write_text("class Robot:\n    pass\n\n\nraise SystemExit\n")
    (tmp_path / "torn.py").write_text("class Robot(:\n")
    for name in ("words.txt", "my --words.txt", "set.zip"):
        (tmp_path / name).write_text("hello\n")
    (tmp_path / "junk.grid").write_bytes(bytes(range(256)))
    said = worldgen("studio", "--no-browser", *(one.format(tmp_path) for one in arguments))
    assert said.code == 2 and words in said.err and said.err.count("\n") <= 2


def test_what_may_be_a_controller_or_a_map_is_left_to_the_page(tmp_path):
    (tmp_path / "loud.py").write_text("from os import *\n\n\nraise SystemExit\n")
    (tmp_path / "made.py").write_text(
        "import sys\nsys.modules[__name__].__dict__['Rob' + 'ot'] = object\n"
    )
    files = [f"{tmp_path}/{name}.py:Robot" for name in ("loud", "made")]
    for label in ("thesis-1+repaired", "cmd:./mine", "json:loads", *files):
        check_controller(label)


def test_without_its_extra_the_command_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert pip_install("studio") in worldgen("studio", tmp_path, "--no-browser").err


def test_the_page_s_parts_are_shipped():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    patterns = project["tool"]["setuptools"]["package-data"]["fuzz.studio"]
    package = Path(str(files("fuzz.studio")))
    parts = [part for part in (package / "page").rglob("*") if part.is_file()]
    shipped = {found for pattern in patterns for found in package.glob(pattern)}
    assert package / "page" / "index.html" in parts
    assert set(parts) <= shipped
