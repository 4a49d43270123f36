"""A studio that serves in a thread, and a page's side of its connection."""

import contextlib
import http.client
import json
import shutil
import threading
import time
from pathlib import Path

import msgspec
import uvicorn
from websockets.sync.client import connect

from fuzz.studio import Folder, Gate, Studio, make_app
from fuzz.studio.answers import answer
from fuzz.studio.requests import messages
from fuzz.studio.requests.folder import Opened
from fuzz.studio.requests.limits import MOST_MESSAGE
from fuzz.studio.requests.protocol import REQUESTS, SUBPROTOCOL, WorldMessage, decoded, encoded
from fuzz.studio.serving import bind

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@contextlib.contextmanager
def studio_of(folder, *, named=(), file=None, port=None):
    """Serve a studio of a folder at a free port, or at a given one; yield its gate."""
    listener = bind("127.0.0.1", port or free_port())
    gate = Gate("127.0.0.1", listener.getsockname()[1])
    app = make_app(Studio(Folder(folder), gate, tuple(named), file))
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_level="warning",
            ws="websockets-sansio",
            ws_max_size=MOST_MESSAGE,
            lifespan="on",
        )
    )
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    try:
        yield gate
    finally:
        server.should_exit = True
        thread.join(timeout=10)
        listener.close()


@contextlib.contextmanager
def studio_of_config_5(folder):
    """A studio that opens the thesis's fifth configuration, the only file of a folder."""
    shutil.copy(CONFIG_5, folder)
    with studio_of(folder, file=CONFIG_5.name) as gate:
        yield gate


def free_port():
    listener = bind("127.0.0.1", None)
    port = listener.getsockname()[1]
    listener.close()
    return port


def get(gate, path="/", *, method="GET", token=True, **headers):
    """Send a request over HTTP; return the answer with its body read."""
    connection = http.client.HTTPConnection("127.0.0.1", gate.port, timeout=120)
    said = {"Cookie": f"{gate.cookie}={gate.cookie_value}"} if token else {}
    said |= {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, headers=said)
    answer = connection.getresponse()
    answer.body = answer.read()
    connection.close()
    return answer


def message_of(world):
    """Return a world as the page sends it."""
    return sent(messages.message_of(world))


def sent(message):
    """Return a message as it arrives: in JSON's types."""
    return json.loads(encoded(message))


def received(message):
    """Return a world from the page as the server receives it."""
    return msgspec.json.decode(json.dumps(message), type=WorldMessage)


def fitting(do, **message):
    """Return the fields of a message that a kind of request takes."""
    return {
        name: value for name, value in message.items() if name in REQUESTS[do].__struct_fields__
    }


class Answers:
    """Answers requests in this process."""

    def __init__(self, folder, named=()):
        self.opened = Opened(Folder(folder), tuple(named))
        self.parts = []

    def ask(self, do, **message):
        request = decoded(json.dumps({"id": 0, "do": do} | message))
        return sent(answer(request, self.opened, lambda part: self.parts.append(sent(part))))


class Page:
    """The page's side of a connection."""

    def __init__(self, socket):
        self.socket, self.number = socket, 0
        self.begins = json.loads(socket.recv())

    def send(self, do, **message):
        """Send a request without waiting; return its number."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "do": do, **message}))
        return self.number

    def hear(self):
        """Return the server's next message."""
        return json.loads(self.socket.recv(timeout=180))

    def ask(self, do, **message):
        """Send a request and wait; return the answer, with its parts as ``parts``."""
        number, parts = self.send(do, **message), []
        while True:
            said = self.hear()
            if said["id"] == number and "part" in said:
                parts.append(said["part"])
            elif said["id"] == number:
                return said | {"parts": parts}


@contextlib.contextmanager
def page_of(gate, *, origin=None, token=True, cookie=True):
    """A connection as the page opens it."""
    headers = {"Cookie": f"{gate.cookie}={gate.cookie_value}"} if cookie else {}
    offered = [SUBPROTOCOL, gate.token] if token else [SUBPROTOCOL]
    place = f"http://127.0.0.1:{gate.port}" if origin is None else origin
    address = f"ws://127.0.0.1:{gate.port}/socket"
    with connect(
        address,
        origin=place or None,
        additional_headers=headers,
        subprotocols=offered,
        max_size=None,
    ) as socket:
        yield Page(socket)
