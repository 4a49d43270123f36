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
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

_IMPORT = re.compile(r"""(?:\bfrom|\bimport) ?\(?"(#[^"]+)\"""")


def one_file(
    body: str,
    title: str,
    *,
    styles: str,
    scripts: Mapping[str, str],
    start: str,
    data: Mapping[str, Any],
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
    template = (files("fuzz.player") / "one_file.html").read_text("utf-8").replace("@@BODY@@", body)
    return filled(template, title, styles=styles, scripts=scripts, start=start, data=data)[0]


def filled(
    template: str,
    title: str,
    *,
    styles: str,
    scripts: Mapping[str, str],
    start: str,
    data: Mapping[str, Any],
) -> tuple[bytes, str]:
    """Return a template with all that its page needs, and the policy that allows nothing else.

    Args:
        template: HTML in which ``@@TITLE@@``, ``@@STYLE@@``, ``@@IMPORTS@@``, ``@@START@@``,
            ``@@DATA@@``, ``@@NONCE@@`` and ``@@POLICY@@`` stand for the contents.
        title: See :func:`one_file`, also for the rest.
        styles: CSS that follows the player's.
        scripts: Text of each module other than the player's.
        start: Name of the module that starts the page.
        data: Data that the scripts read as JSON.
    """
    player = files("fuzz.player") / "page"
    parts = [(player / name).read_text("utf-8") for name in ("marks.css", "player.css")]
    styles = "".join([*parts, styles])
    texts = _imported(start, modules(player, "#player/") | dict(scripts))
    urls = {name: _data_url(text) for name, text in texts.items()}
    contents = {
        "TITLE": html.escape(title.encode("utf-8", "replace").decode("utf-8")),
        "STYLE": styles,
        "IMPORTS": _in_script({"imports": urls}),
        "START": f'import "{start}";',
        "DATA": _in_script(data),
    }

    # A module may be imported if its importer has the policy's nonce. The nonce is a digest of the
    # page's text, so no text in the page can contain it. So nothing in a failure's file can run,
    # and equal pages have equal bytes.
    text = "\0".join([template, *contents.values()])
    nonce = hashlib.sha256(text.encode("utf-8")).hexdigest()[:32]
    sources = f"script-src 'nonce-{nonce}'; style-src {policy_source(styles)}"
    policy = f"default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; {sources}"
    contents |= {"NONCE": nonce, "POLICY": policy}
    page = "".join(contents.get(piece, piece) for piece in template.split("@@"))
    return page.encode("utf-8"), sources


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


def _imported(start: str, texts: Mapping[str, str]) -> dict[str, str]:
    """Return the modules that a page loads: the one that starts it, and what modules import."""
    names = {start}
    left = [start]
    while left:
        found = set(_IMPORT.findall(texts[left.pop()])) - names
        names |= found
        left += found
    return {name: text for name, text in texts.items() if name in names}


def policy_source(text: str) -> str:
    """Return the SHA-256 by which a Content-Security-Policy names an inline script or style."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _in_script(value: Mapping[str, Any]) -> str:
    """Return JSON that cannot end the script element that contains it."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _data_url(script: str) -> str:
    """Return a URL that contains the script, without the characters that URLs drop or end at.

    A browser encodes all others itself. Base64 would be a third longer, and compress badly.
    """
    return f"data:text/javascript,{script.translate(_ENCODED)}"


_ENCODED = {ord(character): f"%{ord(character):02X}" for character in "%#\t\n\r"}
