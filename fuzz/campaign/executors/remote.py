"""Do work elsewhere, after checking that the code there equals the code here."""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import random
import socket
import sys
import tempfile
import threading
import types
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from hypothesis.errors import HypothesisDeprecationWarning

from fuzz.campaign.store import Fingerprint, fingerprint_of
from fuzz.campaign.store.fingerprint import digest_of
from fuzz.oracles import ORACLES, NamedOracle
from fuzz.unit.config import CampaignConfig
from sim.controllers import CONTROLLERS
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.plugins.registry import Registry, lend
from worldgen.plugins.trust import admit
from worldgen.support.paths import expanded

P = ParamSpec("P")
T = TypeVar("T")

# Controllers that are programs, and Hypothesis, belong to one thread.
_ONE = threading.Lock()
_PACKAGES_OF_DASK = ("dask", "distributed", "tornado")
# Key of the job that this process is ready for.
_installed: dict[str, str] = {}
_REGISTRIES: tuple[Registry[Any], ...] = (CONTROLLERS, FAMILIES, ORACLES)


@dataclass(frozen=True)
class RemoteJob:
    """Data sent along with each piece of work.

    Args:
        config: The campaign's configuration.
        fingerprint: Fingerprint of the code here.
        files: Contents of the Python files that the configuration names, by those names.
    """

    config: CampaignConfig
    fingerprint: Fingerprint
    files: Mapping[str, bytes] = field(repr=False)

    @classmethod
    def of(cls, config: CampaignConfig) -> RemoteJob:
        """Return the job of a configuration.

        Raises:
            InvalidParameter: If something that it names cannot be found.
        """
        fingerprint = fingerprint_of(config)
        return cls(
            config, fingerprint, {place: expanded(place).read_bytes() for place in _places(config)}
        )

    def run(self, work: Callable[P, T], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> T:
        """Do the work in this process, after checking its code.

        Raises:
            InvalidParameter: If the code differs.
        """
        # Threads of the worker may draw from `random` while Hypothesis checks in this thread
        # whether a strategy did.
        warnings.filterwarnings(
            "ignore", "Do not use the `random` module", HypothesisDeprecationWarning
        )
        with _ONE:
            give_dask_its_own_random()
            _install_and_compare(self)
            return work(*args, **kwargs)


def give_dask_its_own_random() -> None:
    """Let the modules of Dask draw from a copy of ``random``.

    Its threads draw while this one works. A draw from the global generator would look like hidden
    state of a Python controller, whose loop could then not be proved.
    """
    own = _copy_of_random()
    shared = random.random.__self__  # type: ignore[attr-defined]  # the global generator
    for name, module in [*sys.modules.items()]:
        if name.partition(".")[0] not in _PACKAGES_OF_DASK:
            continue
        for key, value in [*vars(module).items()]:
            if value is random:
                setattr(module, key, own)
            elif getattr(value, "__self__", None) is shared:
                setattr(module, key, getattr(own, value.__name__))


@functools.cache
def _copy_of_random() -> types.ModuleType:
    """Return a second module ``random``, with a generator of its own."""
    found = importlib.util.find_spec("random")
    assert found is not None
    assert found.loader is not None
    copy = importlib.util.module_from_spec(found)
    found.loader.exec_module(copy)
    return copy


def _places(config: CampaignConfig) -> list[str]:
    """Return the Python files that a configuration names."""
    names = [
        config.scenario.controller,
        *config.families,
        *(NamedOracle.parse(text).name for text in config.oracles),
    ]
    return sorted(
        {name.rpartition(":")[0] for name in names if name.rpartition(":")[0].endswith(".py")}
    )


def _install_and_compare(job: RemoteJob) -> None:
    """Install the job's files, and check that all code is the same.

    This happens once per campaign.

    Raises:
        InvalidParameter: If it differs.
    """
    key = digest_of([job.fingerprint.digest, sorted(job.files)])
    if _installed.get("job") == key:
        return
    _installed.clear()
    # Whoever may submit work may run any code, so its names are as good as typed ones.
    admit(job.config.scenario.controller, *job.config.families, *job.config.oracles)
    for place, data in job.files.items():
        lend(place, _copy(Path(place).name, data))
        for registry in _REGISTRIES:
            registry.forget(place)
    said = job.fingerprint.differences(fingerprint_of(job.config))
    if said:
        raise InvalidParameter(
            "other-code",
            "the worker on {host} runs different code: {differences!l}",
            "install the same code there as here, and restart the workers",
            host=socket.gethostname(),
            differences=list(said),
        )
    _installed["job"] = key


def _copy(name: str, data: bytes) -> Path:
    """Return a file with this content, in a folder that is deleted with this process."""
    folder = Path(_folder().name) / hashlib.sha256(data).hexdigest()
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(data)
    return folder / name


@functools.cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="worldgen-")
