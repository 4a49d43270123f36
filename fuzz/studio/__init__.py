"""The studio: a local web page on which you draw worlds and run robots.

It does nothing that the library and the command line cannot do. A browser and a server exchange
small messages (fuzz/studio/protocol.md), and each becomes one call of the Python API.

Contents:
    Studio, make_app: The server's settings, and the server as an ASGI application (``app``).
    Folder: The only folder that is read and written (``folder``).
    Gate: Access control (``gate``).
    Answers: Answers each message by one call of the library (``answers``), in separate processes
        (``workers``).
"""

from fuzz.studio.app import Studio, make_app
from fuzz.studio.gate import Gate
from fuzz.studio.requests.folder import Folder

__all__ = ["Folder", "Gate", "Studio", "make_app"]
