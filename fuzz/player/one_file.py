"""Build a page in one file: text, style, scripts and data, with nothing else to load.

The scripts are ES modules. Each is a ``data:`` URL, and an import map gives it the name by which
the others import it. A module under a ``data:`` URL has no folder, so imports name modules as
``#player/dom.js``, never as ``./dom.js``.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Mapping, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any


def one_file(
    body: str,
    title: str,
    *,
    styles: str,
    scripts: Mapping[str, str],
    start: str,
    data: dict[str, Any],
) -> bytes:
    """Return the page, which allows a browser to run only these scripts and to load nothing.

    Args:
        body: Contents of the page, as HTML; ``@@TITLE@@`` in it stands for the title.
        title: Title of the page, as plain text.
        styles: CSS that follows the player's.
        scripts: Text of each module other than the player's, by the name used in imports.
        start: Name of the module that starts the page.
        data: Data that the scripts read as JSON.
    """
    player = files("fuzz.player") / "page"
    parts = [(player / name).read_text("utf-8") for name in ("marks.css", "player.css")]
    styles = "".join([*parts, styles])
    texts = modules(player, "#player/") | dict(scripts)
    urls = {name: _data_url(text) for name, text in texts.items()}
    filled = {
        "TITLE": html.escape(title.encode("utf-8", "replace").decode("utf-8")),
        "STYLE": styles,
        "IMPORTS": json.dumps({"imports": urls}, separators=(",", ":")),
        "START": f'import "{start}";',
        "DATA": json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    }

    # A module may be imported if its importer has the policy's nonce. The nonce is a digest of the
    # page's text, so no text in the page can contain it. So nothing in a failure's file can run,
    # and equal pages have equal bytes.
    nonce = hashlib.sha256("\0".join([body, *filled.values()]).encode("utf-8")).hexdigest()[:32]
    filled["NONCE"] = nonce
    filled["POLICY"] = (
        "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
        f"script-src 'nonce-{nonce}'; style-src {policy_source(styles)}"
    )
    template = (files("fuzz.player") / "one_file.html").read_text("utf-8").replace("@@BODY@@", body)
    return "".join(filled.get(piece, piece) for piece in template.split("@@")).encode("utf-8")


def replay_page(
    title: str, world: dict[str, Any] | None, robots: Sequence[dict[str, Any]]
) -> bytes:
    """Return robots in one world as a page that can be sent to anyone with a browser.

    Args:
        title: Heading.
        world: Result of ``drawn_world``.
        robots: Each with ``name``, ``verdict``, ``why``, ``steps``, ``time``, ``path``,
            ``collisions``, ``digest``, and ``run`` and ``sensors`` as the player draws them.
    """
    folder = files("fuzz.player") / "replay_page"
    body = (folder / "body.html").read_text("utf-8")
    styles = (folder / "style.css").read_text("utf-8")
    scripts = modules(folder, "#replay/")
    data = {"title": title, "world": world, "robots": list(robots)}
    return one_file(
        body, title, styles=styles, scripts=scripts, start="#replay/start.js", data=data
    )


def modules(folder: Traversable, prefix: str) -> dict[str, str]:
    """Return the text of each JavaScript module in and below a folder, by the name used in imports.

    Args:
        folder: Folder of the ``.js`` files.
        prefix: Prefix of a file's name in imports, such as ``#report/``.
    """
    found: dict[str, str] = {}
    for part in sorted(folder.iterdir(), key=lambda part: part.name):
        if part.is_dir():
            found |= modules(part, f"{prefix}{part.name}/")
        elif part.name.endswith(".js"):
            found[f"{prefix}{part.name}"] = part.read_text("utf-8")
    return found


def policy_source(text: str) -> str:
    """Return the SHA-256 by which a Content-Security-Policy names an inline script or style."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _data_url(script: str) -> str:
    """Return a URL that contains the script."""
    return f"data:text/javascript;base64,{base64.b64encode(script.encode('utf-8')).decode('ascii')}"
