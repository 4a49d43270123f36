"""Every controller by its name, and a fresh one for each run.

Contents:
    CONTROLLERS: Finds a controller by name, as ``package.module:name``, ``./file.py:name``, or
        ``cmd:./program --flag``.
    controller_of: Finds a controller by name, or checks the one that it is given.
    called: Returns a controller's name for messages and tables.
    in_plain_place: Normalises the path in a controller's name.
    names_in: Splits a comma-separated list of controllers.
    own_words: Splits a name from a controller's own options.
"""

from sim.controllers.catalogue.registry import (
    CONTROLLERS,
    called,
    controller_of,
    in_plain_place,
    names_in,
    own_words,
)

__all__ = ["CONTROLLERS", "called", "controller_of", "in_plain_place", "names_in", "own_words"]
