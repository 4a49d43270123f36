"""``worldgen studio``: draw worlds, run robots in them and watch, in the browser."""

from __future__ import annotations

from pathlib import Path

import click

from worldgen.cli.output import PATH, note

EXAMPLES = (
    "\b\n  worldgen studio\n  worldgen studio worlds/maze.grid\n  worldgen studio "
    "--controller ./mine.py:Robot"
)


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH, default=".", metavar="[PATH|DIR]")
@click.option(
    "--controller",
    "controllers",
    multiple=True,
    help=(
        "Allow the page to run this controller of yours, such as ./mine.py:Robot; may be repeated."
    ),
)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to listen on; any address but the default exposes the studio to the network.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    help="Port to listen on; 0 picks any free port.  [default: 8642, or a free port]",
)
@click.option("--browser/--no-browser", default=True, help="Open the browser.  [default: open]")
def studio(
    path: Path, controllers: tuple[str, ...], host: str, port: int | None, browser: bool
) -> None:
    """Draw worlds and watch robots run in them, in your browser.

    PATH is a folder or a world's file; the page can read and write only that folder, or the one
    that contains the file. The server answers only this machine, and only the browser that opens
    the printed address. docs/howto/studio.md describes the page.
    """
    import importlib.util
    import ipaddress

    from worldgen.errors import FormatError, InvalidParameter
    from worldgen.plugins.installation import pip_install

    # Refuse anything that cannot be served, and name the command that helps.
    missing = [
        name
        for name in ("starlette", "uvicorn", "websockets")
        if importlib.util.find_spec(name) is None
    ]
    if missing:
        raise InvalidParameter(
            "package-missing",
            "the studio needs {missing!l}",
            "{install}",
            at_terminal=True,
            missing=list(missing),
            install=pip_install("studio"),
        )
    if not path.exists():
        raise FormatError(
            "no-such-file", "there is no such file or folder", "check the name", source=str(path)
        )
    # The studio shares the folder of a file, which for a device would be the machine's.
    if not (path.is_file() or path.is_dir()):
        raise FormatError(
            "not-a-file",
            "it is neither a file nor a folder",
            "name a world's file, or a folder of worlds",
            source=str(path),
        )
    if path.suffix == ".py" and path.is_file():
        place = path if path.is_absolute() else f"./{path}"
        raise InvalidParameter(
            "not-a-world",
            "{path} is not a world",
            "run its robot NAME with worldgen studio --controller {place}:NAME",
            at_terminal=True,
            path=path,
            place=place,
        )

    from fuzz.studio.starting import check_controller, check_world

    # Check the controllers and the world before the page opens.
    for label in controllers:
        check_controller(label)
    if path.is_file():
        check_world(path)

    from fuzz.studio import Folder, Gate, Studio
    from fuzz.studio.serving import bind, called, serve

    # Open the socket, and warn if other machines can reach it.
    listener = bind(host, port)
    address, number = listener.getsockname()[:2]
    gate = Gate(called(host, listener), number)
    if not ipaddress.ip_address(address).is_loopback:
        warning = (
            f"warning: anyone who can reach {gate.host} and learns the address can read and write "
            f"the folder"
        )
        note(warning, always=True)
    # Serve.
    folder, file = (path, None) if path.is_dir() else (path.parent, path.name)
    shared = Folder(folder)
    # Without the address nobody can find the page.
    note(f"studio of {shared.root}: open {gate.address}", always=True)
    serve(Studio(shared, gate, controllers, file), listener, browse=browser, said=note)
