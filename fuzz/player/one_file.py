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
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from fuzz.player.sources import player_modules, style

__all__ = ["one_file", "policy_source"]


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
    styles = style() + styles
    urls = {name: _data_url(text) for name, text in (player_modules() | dict(scripts)).items()}
    filled = {
        "TITLE": html.escape(title.encode("utf-8", "replace").decode("utf-8")),
        "STYLE": styles,
        "IMPORTS": json.dumps({"imports": urls}, separators=(",", ":")),
        "START": f'import "{start}";',
        "DATA": json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    }

    # A module may be imported if its importer has the policy's nonce. The nonce is a digest of the
    # page's text, so no text in the page can contain it. Hence nothing in a failure's file can run,
    # and equal pages get equal bytes.
    nonce = hashlib.sha256("\0".join([body, *filled.values()]).encode("utf-8")).hexdigest()[:32]
    filled["NONCE"] = nonce
    filled["POLICY"] = (
        "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
        f"script-src 'nonce-{nonce}'; style-src {policy_source(styles)}"
    )
    template = (files("fuzz.player") / "one_file.html").read_text("utf-8").replace("@@BODY@@", body)
    return "".join(filled.get(piece, piece) for piece in template.split("@@")).encode("utf-8")


def policy_source(text: str) -> str:
    """Return the SHA-256 by which a Content-Security-Policy names an inline script or style."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _data_url(script: str) -> str:
    """Return a URL that contains the script."""
    return f"data:text/javascript;base64,{base64.b64encode(script.encode('utf-8')).decode('ascii')}"
