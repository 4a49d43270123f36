"""Begin each run with a controller that no earlier run has changed.

A class that follows the contract clears all of its state in ``reset``. If one that does not were
reused, its runs would depend on earlier ones, and no file could replay them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from sim.clock.controller_time import Effort, count_survivors
from sim.controllers.base import Controller, Memory
from sim.controllers.catalogue import CONTROLLERS, own_words
from sim.controllers.contract import runs_differ, state_survives_reset
from sim.controllers.hidden_state import HiddenState, hidden_state, own_attributes
from sim.controllers.instances import InstanceOrigin, origin_of
from sim.controllers.programs.process import ProcessController
from sim.controllers.shared.guarded import renew
from sim.controllers.shared.object_file import is_library_name
from worldgen.errors import Message
from worldgen.plugins.user_modules import digest_of_source, sources_read
from worldgen.support.paths import expanded, real_path

_SHARED = "a variable of its class or module"


def as_loaded(name: str) -> Controller:
    """Return a controller in the state in which it was loaded.

    A program, and the process of a shared library, are ended, so that the next run starts them
    again. The variables of classes and modules are set back; only where that is impossible, the
    file is loaded again.
    """
    found = CONTROLLERS.get(name)
    origin = origin_of(found)
    if isinstance(found, ProcessController):
        found.close()
    elif is_library_name(name):
        renew()
    elif origin is not None and origin.shared is not None:
        place = own_words(name)[0].rpartition(":")[0]
        file = CONTROLLERS.source(name)
        has_changed = has_shared_state_changed(found, hidden_state(found))
        # Installed modules stay imported, so only the user's own file can be loaded again.
        if has_changed and place.endswith(".py") and file is not None and _is_unedited(file):
            if origin.loaded is not None and origin.loaded.restore(type(found)):
                CONTROLLERS.renew(place)
            else:
                CONTROLLERS.forget(place)
    return CONTROLLERS.get(name)


def _is_unedited(file: Path) -> bool:
    """Return True if a file, and those next to it that were read as code, are still the same.

    Loading an edited file would run other code in the second half of a campaign.
    """
    folder = real_path(expanded(file)).parent
    try:
        return all(
            digest_of_source(Path(path).read_bytes()) == digest
            for path, digest in sources_read().items()
            if Path(path).is_relative_to(folder)
        )
    except OSError:
        return False


def has_shared_state_changed(controller: object, state: HiddenState | None) -> bool:
    """Return True if runs have changed a variable of the controller's class or module.

    Args:
        controller: The controller; False if the user made it.
        state: Its state now; at the first call, its first run has just been prepared.
    """
    origin = origin_of(controller)
    if origin is None or state is None:
        return False
    if origin.shared is None:
        origin.shared = state.shared
    if origin.shared == state.shared:
        return False
    if origin.changed is None:
        before = origin.loaded
        origin.changed = [] if before is None else before.changed()
    count_survivors(f"the variable {one}" for one in origin.changed)
    if not origin.changed:
        count_survivors([_SHARED])
    return True


def renew_and_reset(
    controller: Any, reset: Callable[[Any], Memory], *, plans: bool
) -> tuple[Any, Memory]:
    """Reset a controller; take another instance if earlier runs have left something in this one.

    Args:
        controller: The controller.
        reset: Resets a controller and returns its memory.
        plans: Whether ``reset`` takes the world. What it then keeps may depend on the world, so
            only the state before it can be compared.

    Returns:
        The controller that is to run, and its memory.
    """
    memory = None if plans else reset(controller)
    origin = origin_of(controller)
    left = set() if origin is None else _left_in(controller, origin)
    if origin is not None and left:
        controller = origin.another()
        memory = None if plans else reset(controller)
        # An attribute that also differs in a new instance was not left by a run.
        origin.varying |= _left_in(controller, origin)
        # A plan made by the last ``reset`` is no fault: the next one replaces it.
        if not plans:
            count_survivors(f"self.{name}" for name in left - origin.varying)
    return controller, reset(controller) if memory is None else memory


def _left_in(controller: object, origin: InstanceOrigin) -> set[str]:
    """Return the attributes that have changed since the first run began."""
    now = own_attributes(controller)
    if origin.own is None:
        origin.own = now
    names = origin.own.keys() | now.keys()
    differ = {name for name in names if origin.own.get(name) != now.get(name)}
    return differ - origin.varying


def survivors_found(controllers: Iterable[str], began: Effort) -> list[Message]:
    """Return messages about state that survives ``reset``, and about what makes equal runs differ.

    Args:
        controllers: Names of the controllers that ran.
        began: A reading from before their first run.

    Returns:
        A message about each of the two, if there is something to say.
    """
    effort = began.since()
    names = ", ".join(dict.fromkeys(controllers))
    both = ((effort.survivors, state_survives_reset), (effort.differences, runs_differ))
    return [message(names, places) for places, message in both if places]
