"""The studio: a local web page on which worlds are drawn, decided and run.

It does nothing that the library and the command line do not: a browser and a server exchange small
    messages
(docs/reference/studio-protocol.md), and each becomes one call of the Python API.

Contents:
    Studio, make_app: the server's settings, and the server as an ASGI application (``app``).
    Folder: the one folder that can be read and written (``folder``).
    Gate: who is let in (``gate``).
    Answers: what a message asks for, as one call of the library (``answers``), in processes of its
        own (``lanes``).
"""

from fuzz.studio.app import Studio, make_app
from fuzz.studio.folder import Folder
from fuzz.studio.gate import Gate

__all__ = ["Folder", "Gate", "Studio", "make_app"]
