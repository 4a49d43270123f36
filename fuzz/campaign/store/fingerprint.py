"""Identify what determines the results of a campaign's units: the configuration, and the code."""

from __future__ import annotations

import functools
import hashlib
import importlib
import json
import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fuzz.layouts.variation import Variation
from fuzz.oracles import ORACLES, NamedOracle
from fuzz.unit.config import CampaignConfig
from fuzz.unit.pace import Pace
from sim.controllers import CONTROLLERS, ProcessController
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen.domain import MASK64
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, loads
from worldgen.plugins.registry import Registry
from worldgen.plugins.trust import NameInFile, note_names
from worldgen.support.plain_text import quote

_OWN = ("worldgen", "sim", "fuzz")
_SHOWS = (
    "fuzz/ci",
    "fuzz/commands",
    "fuzz/overview",
    "fuzz/player",
    "fuzz/report",
    "fuzz/studio",
    "worldgen/cli",
    "worldgen/commands",
)
"""Packages that only present campaigns and do not affect their results.

A contract in pyproject.toml ensures that no search imports them.
"""
_LEFT_OUT = tuple(f"{folder}/" for folder in _SHOWS)
_COMPILED = (".so", ".pyd")
# Hex digits of every digest here.
_DIGITS = 16
# Characters of a value in a message.
_LONGEST = 60


@dataclass(frozen=True)
class Fingerprint:
    """A configuration and the code that belongs to it.

    Campaigns with equal fingerprints have equal findings.

    Args:
        configuration: The campaign's configuration, in JSON's types.
        code: Digests and versions of everything else that determines a unit's result.
    """

    configuration: Mapping[str, Any]
    code: Mapping[str, str]

    @functools.cached_property
    def digest(self) -> str:
        """First hex digits of the SHA-256 of both parts."""
        return digest_of([self.configuration, self.code])

    def differences(self, now: Fingerprint) -> list[str]:
        """Describe how another fingerprint differs from this one: ``seed is 5, not 6``."""
        was = dict(_leaves(self.configuration))
        is_now = dict(_leaves(now.configuration))
        found = []
        for path in sorted(was.keys() | is_now.keys()):
            before = was.get(path)
            after = is_now.get(path)
            if before != after:
                # For a nested name, its first and last part suffice: "scenario beams".
                name = " ".join(dict.fromkeys((path[0], path[-1])))
                found.append(f"{name} is {quote(before, _LONGEST)}, not {quote(after, _LONGEST)}")
        # Another configuration has other code, such as another controller's: naming it says nothing
        # more.
        names = self.code.keys() & now.code.keys() if found else self.code.keys() | now.code.keys()
        for name in sorted(names):
            before = self.code.get(name, "none")
            after = now.code.get(name, "none")
            if before != after:
                found.append(f"{name} was {before} and is now {after}")
        return found


def _leaves(
    configuration: Mapping[str, Any], path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the values inside nested configurations, each with the names that lead to it."""
    for name, value in configuration.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*path, name))
        else:
            yield (*path, name), value


def fingerprint_of(config: CampaignConfig) -> Fingerprint:
    """Return the fingerprint of a configuration, with the code as it is now.

    Raises:
        InvalidParameter: If a controller, family or oracle cannot be found.
    """
    code = {
        "worldgen": f"{version('worldgen')} ({_own_sources()})",
        "hypothesis": version("hypothesis"),
    }
    code |= {name: digest for name, digest in _other_sources(config) if digest}
    return Fingerprint(_configuration(config), code)


def digest_of(value: Any) -> str:
    """Return the first hex digits of the SHA-256 of a value in JSON's types."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]


def _configuration(config: CampaignConfig) -> dict[str, Any]:
    plain = {field.name: getattr(config, field.name) for field in fields(config)}
    scenario = config.scenario
    plain["scenario"] = {
        "controller": scenario.controller,
        "motion": scenario.run.motion,
        "seed": scenario.run.seed,
        "parameters": replace(scenario.run, steps=1).parameters(),
    }
    plain["fixed_map"] = None if config.fixed_map is None else dumps(config.fixed_map).decode()
    # Replace tuples by lists, as when it is read back.
    configuration: dict[str, Any] = json.loads(json.dumps(plain, default=asdict))
    return configuration


def config_of(configuration: Mapping[str, Any], source: str | None = None) -> CampaignConfig:
    """Return the stored configuration.

    Args:
        configuration: What is stored.
        source: The campaign's folder, for messages.

    Raises:
        WorldgenError: If part of it is out of range.
        TypeError, ValueError, KeyError: If it isn't a configuration.
    """
    values: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in configuration.items()
    }
    said = values.pop("scenario")
    note_names(configuration, source)
    controller = NameInFile(said["controller"])
    motion = str(said["motion"])
    seed = int(said["seed"])
    scenario = Scenario(controller, RunOptions.of(motion, seed, said["parameters"]))
    text = values.pop("fixed_map")
    fixed_map = None if text is None else loads(text.encode())
    vary = tuple(Variation(str(one["name"]), tuple(one["values"])) for one in values.pop("vary"))
    measured = pace_of(values.pop("measured", None))
    config = CampaignConfig(scenario, fixed_map=fixed_map, vary=vary, measured=measured, **values)
    if not 0 <= config.seed <= MASK64:
        raise ValueError(f"seed is {config.seed}")
    usual = CampaignConfig(scenario)
    for field in fields(config):
        if field.name not in ("fixed_map", "measured") and type(
            getattr(config, field.name)
        ) is not type(getattr(usual, field.name)):
            raise TypeError(f"{field.name} is {getattr(config, field.name)!r}")
    return config


def pace_of(stored: Mapping[str, Any] | None) -> Pace | None:
    """Return the measured pace in a stored configuration.

    Raises:
        TypeError, ValueError, KeyError: If it isn't one.
    """
    if stored is None:
        return None
    pace = Pace(float(stored["step"]), float(stored["reset"]))
    if not (0.0 <= pace.step < math.inf and 0.0 <= pace.reset < math.inf):
        raise ValueError(f"measured is {stored!r}")
    return pace


@functools.cache
def _own_folders() -> list[Path]:
    return [Path(str(importlib.import_module(name).__file__)).parent for name in _OWN]


@functools.cache
def _own_sources() -> str:
    """Return a digest of our own files, because it is hard to tell which ones a unit depends on."""
    return digest_of_sources(_own_folders())


def digest_of_sources(folders: Sequence[Path]) -> str:
    """Return a digest of packages' files, without those that only present results.

    Compiled files are excluded: another compiler's core computes the same.

    Args:
        folders: Folders of the packages.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for file in sorted(folder.rglob("*")):
            name = file.relative_to(folder.parent).as_posix()
            if (
                file.suffix in _COMPILED
                or "__pycache__" in file.parts
                or name.startswith(_LEFT_OUT)
            ):
                continue
            if file.is_file():
                digest.update(f"{name}\0".encode() + file.read_bytes())
    return digest.hexdigest()[:_DIGITS]


def _other_sources(config: CampaignConfig) -> Iterator[tuple[str, str]]:
    """Yield objects that are not our own, with their digests."""
    yield controller_source(config.scenario.controller)
    for name in config.families:
        yield f"family {name}", _digest_of_source(FAMILIES, name)
    for text in config.oracles:
        yield f"oracle {text}", _digest_of_source(ORACLES, NamedOracle.parse(text).name)


def controller_source(controller: str) -> tuple[str, str]:
    """Return the name and the digest of a controller's source, as fingerprints have them.

    The digest is empty if it is ours or has no file.

    Raises:
        InvalidParameter: If it cannot be found.
    """
    found = CONTROLLERS.get(controller)
    if isinstance(found, ProcessController):
        return f"program {controller}", _digest_of_program(found.command)
    return f"controller {controller}", _digest_of_source(CONTROLLERS, controller)


def _digest_of_source(registry: Registry[Any], name: str) -> str:
    """Return the digest of the file that defines an object; empty if it is ours or has no file."""
    file = registry.source(name)
    ours = file is not None and any(file.is_relative_to(folder) for folder in _own_folders())
    return "" if file is None or ours else _digest_of_files(file)


def _digest_of_program(command: Sequence[str]) -> str:
    """Return the digest of a program: of the files that its command names."""
    paths = [Path(shutil.which(word) or word) for word in command]
    return _digest_of_files(*(path for path in paths if path.is_file()))


def _digest_of_files(*files: Path) -> str:
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:_DIGITS]
