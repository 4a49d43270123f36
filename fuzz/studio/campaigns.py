"""Campaigns from the page: each is a `worldgen fuzz` in a process of its own, and its folder the only tie to it.

So a campaign outlives the page and the server, and one that was begun at a terminal is seen and stopped here, too. What
a folder from elsewhere asks for, a controller or an oracle in a file, is not run unless it was named at the start.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzz.asked import ORACLES
from fuzz.corpus import read_corpus
from fuzz.lanes import OWN_LANES
from fuzz.ledger import CampaignFolder
from fuzz.report.summary import MEMORY
from fuzz.studio.campaign_state import SAID, campaign_state, is_campaign, running_process
from fuzz.studio.folder import Folder
from fuzz.studio.messages import field as part_of
from fuzz.studio.messages import restored
from fuzz.studio.running import may_run
from sim.controllers import CONTROLLERS
from sim.motion import MOTIONS
from worldgen.errors import InvalidParameter, OutputError, WorldgenError
from worldgen.family import FAMILIES
from worldgen.grid_file import read_world, write_world
from worldgen.world_files import files_in

__all__ = ["KNOWN", "CampaignAnswers"]

KNOWN = "known"
"""The folder, in the opened one, of failures that are marked as known: the baseline of campaigns begun here."""

_BEGINS = 90.0  # s that a process gets until it has begun; kernels may have to be compiled
_ENDS = 2.0  # s that a campaign is waited for that was told to end; it may end later
_LOOK = 0.05  # s between two looks
_MOST_SECONDS, _MOST_UNITS, _MOST_EXAMPLES, _MOST_WORKERS = 7 * 86_400.0, 1_000_000, 100_000, 256

Message = Mapping[str, Any]


@dataclass(frozen=True)
class CampaignAnswers:
    """What the campaign page asks for, as far as campaigns' processes are concerned.

    Args:
        folder: What can be read and written.
        named: Controllers that were named at the start, beside the registered ones.
    """

    folder: Folder
    named: Sequence[str] = ()
    _begun: list[subprocess.Popen[bytes]] = field(default_factory=list, init=False, repr=False, compare=False)

    def campaigns(self, message: Message, part: object) -> dict[str, Any]:
        """The campaigns in the folder, those that run first; folders that hold worlds; and what a form offers."""
        self._reap()
        folders = _folders(self.folder)
        states, faults = [], []
        for name in folders:
            try:
                states += [campaign_state(self.folder.place(name), name)] if self._is_campaign(name) else []
            except WorldgenError as error:  # of one; the others are as they were
                faults.append(str(error))
        return {
            "faults": faults,
            "campaigns": sorted(states, key=lambda state: (not state["running"], state["folder"])),
            "folders": [{"name": name, "worlds": count} for name, count in folders.items() if count],
            "known": KNOWN,
            "lanes": list(OWN_LANES),
            "oracles": ORACLES.names(),
            "cores": os.cpu_count() or 1,
        }

    def begin(self, message: Message, part: object) -> dict[str, Any]:
        """Begins a campaign in a folder, or goes on with the same one."""
        self._reap()
        name = part_of(message, "folder", str)
        out = self._own(name)
        words = [f"--controller={self._controller(message)}", f"--motion={_one_of(message, 'motion', MOTIONS.names())}"]
        words += [f"--lane={lane}" for lane in _some_of(message, "lanes", (*OWN_LANES, *FAMILIES.names()))]
        words += [f"--oracle={text}" for text in _oracles(message.get("oracles", []))]
        words += [f"--vary={text}" for text in _texts(message, "vary")]
        if message.get("time_step") is not None:
            words.append(f"--time-step={part_of(message, 'time_step', float)!r}")
        if message.get("examples") is not None:
            words.append(f"--examples={_whole(message, 'examples', _MOST_EXAMPLES)}")
        if message.get("seed") is not None:
            words.append(f"--seed={_seed(message)}")
        with tempfile.TemporaryDirectory() as there:
            if message.get("world") is not None:
                fixed = Path(there) / "world.grid"
                write_world(restored(part_of(message, "world", dict)), fixed)
                words.append(f"--world={fixed}")
            self._start(out, [*words, f"--out={out}", *_goal(message, needed=True), *self._known(message)], message)
        return {"state": campaign_state(out, name)}

    def resume(self, message: Message, part: object) -> dict[str, Any]:
        """Goes on with the campaign in a folder."""
        self._reap()
        name = part_of(message, "folder", str)
        out = self._own(name)
        self._check_stored(out, name)
        self._start(out, [f"--resume={out}", *_goal(message, needed=False), *self._known(message)], message)
        return {"state": campaign_state(out, name)}

    def stop(self, message: Message, part: object) -> dict[str, Any]:
        """Has a campaign end as Ctrl-C would; all that was found is kept."""
        name = part_of(message, "folder", str)
        out = self._own(name)
        process = running_process(out)
        if process is not None:
            with contextlib.suppress(ProcessLookupError):  # it has just ended by itself
                os.kill(process, signal.SIGINT)
        until = time.monotonic() + _ENDS
        while process is not None and running_process(out) is not None and time.monotonic() < until:
            time.sleep(_LOOK)
        self._reap()
        return {"state": campaign_state(out, name)}

    def _is_campaign(self, name: str) -> bool:
        try:
            return bool(name) and is_campaign(self._own(name))
        except InvalidParameter:
            return False

    def _own(self, name: str) -> Path:
        """A folder in the opened one whose memory is no link to somewhere else."""
        out = self.folder.place(name)
        memory = out / MEMORY
        if (
            out == self.folder.root
            or memory.is_symlink()
            or (memory.is_dir() and any(map(Path.is_symlink, memory.iterdir())))
        ):
            raise InvalidParameter(f"{name!r} is no folder of a campaign in the opened one; give the name of another")
        if out.is_relative_to(self.folder.root / KNOWN):
            raise InvalidParameter(
                f"{KNOWN}/ is for failures that are marked as known; give the name of another folder"
            )
        return out

    def _controller(self, message: Message) -> str:
        label: str = part_of(message, "controller", str)
        if label not in self.named and label not in CONTROLLERS.names():
            raise InvalidParameter(
                f"controller {label[:60]!r} was not named when the studio was started; start it with --controller"
            )
        return label

    def _check_stored(self, out: Path, name: str) -> None:
        """Refuses a campaign that would run what nobody has named; its folder may come from anywhere."""
        stored = CampaignFolder.stored_in(out)
        if stored is None:
            raise InvalidParameter(f"{name} holds no campaign to go on with; begin one")
        said = stored[0].configuration
        scenario = said.get("scenario")
        if not isinstance(scenario, dict) or not may_run(str(scenario.get("controller")), self.named):
            raise InvalidParameter(f"{name} runs a controller that was not named at the start; start with --controller")
        if scenario.get("motion") not in MOTIONS.names():
            raise InvalidParameter(f"{name} uses a motion model of a file; resume it at a terminal")
        _some_of({"lanes": said.get("families")}, "lanes", (*OWN_LANES, *FAMILIES.names()))
        _oracles(said.get("oracles"))
        if said.get("database"):
            raise InvalidParameter(f"{name} uses a database outside of the opened folder; resume it at a terminal")

    def _known(self, message: Message) -> list[str]:
        """The baseline, if it is wanted and there is one."""
        known = self.folder.place(KNOWN)
        if message.get("known") is not True or not known.is_dir() or not files_in(known):
            return []
        for file in files_in(known):
            if file.is_symlink():
                raise InvalidParameter(f"{KNOWN}/ holds a link, {file.name}; copy the file into it")
        for entry in read_corpus([known]).entries:  # whose oracles would be asked again
            record = read_world(entry.path).failure
            if record is not None and "oracle" in record.evidence:
                _oracles([record.evidence["oracle"]])
        return [f"--baseline={known}"]

    def _start(self, out: Path, words: list[str], message: Message) -> None:
        """Starts a campaign's process and waits until it has begun.

        Raises:
            OutputError: If it does not begin; with what it says.
        """
        if running_process(out) is not None:
            raise OutputError(f"the campaign in {out.name} runs already; stop it first")
        if message.get("workers") is not None:
            words = [*words, f"--workers={_whole(message, 'workers', _MOST_WORKERS)}"]
        memory = out / MEMORY
        made = [folder for folder in (memory, out, *out.parents) if not folder.exists()]
        try:
            memory.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                f"{out.name} cannot be written: {error.strerror or error}; name another folder"
            ) from error
        with (memory / SAID).open("wb") as said:
            process = _process([sys.executable, "-m", "worldgen", "fuzz", "--json", *words], said)
        self._begun.append(process)
        until = time.monotonic() + _BEGINS
        while process.poll() is None and not (running_process(out) == process.pid and is_campaign(out)):
            if time.monotonic() > until:
                process.kill()
                raise OutputError(f"the campaign has not begun within {_BEGINS:g} s; try it at a terminal")
            time.sleep(_LOOK)
        if process.returncode is None or process.returncode in (0, 1, 130):
            return
        why = _last_words(memory / SAID)
        (memory / SAID).unlink(missing_ok=True)
        for folder in made:
            with contextlib.suppress(OSError):  # it holds something
                folder.rmdir()
        raise OutputError(why)

    def _reap(self) -> None:
        """Takes note of processes that ended."""
        self._begun[:] = [process for process in self._begun if process.poll() is None]


def _process(command: list[str], said: Any) -> subprocess.Popen[bytes]:
    """A process that Ctrl-C at the server's terminal does not reach, and ours does."""
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)  # what is ignored here would be ignored there
    try:
        return subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True
        )
    finally:
        signal.signal(signal.SIGINT, before)


def _last_words(path: Path) -> str:
    lines = [line.strip() for line in path.read_text("utf-8", "replace").splitlines() if line.strip()]
    last = lines[-1] if lines else "the campaign's process ended without a word"
    return last.removeprefix("worldgen: ").removeprefix("Error: ")


def _folders(folder: Folder) -> dict[str, int]:
    """Folders below the opened one, and how many worlds are in each and below; "" is the opened one itself."""
    counts: dict[str, int] = {"": 0}
    for entry in folder.files():
        if entry["world"]:
            parts = entry["name"].split("/")[:-1]
            for depth in range(len(parts) + 1):
                name = "/".join(parts[:depth])
                counts[name] = counts.get(name, 0) + 1
    for name in folder.folders():
        counts.setdefault(name, 0)
    return dict(sorted(counts.items()))


def _one_of(message: Message, name: str, offered: Iterable[str]) -> str:
    said = part_of(message, name, str)
    if said not in offered:
        raise InvalidParameter(f"{name} {said[:40]!r} is not registered; choose one of the list")
    return str(said)


def _some_of(message: Message, name: str, offered: Sequence[str]) -> list[str]:
    return [_one_of({name: one}, name, offered) for one in part_of(message, name, list)]


def _texts(message: Message, name: str) -> list[str]:
    return [part_of({name: one}, name, str) for one in part_of(message, name, list)] if name in message else []


def _oracles(texts: object) -> list[str]:
    """Oracles that are registered: others are code of files."""
    said = _texts({"oracles": texts}, "oracles")
    for text in said:
        if text.partition("=")[0].strip() not in ORACLES.names():
            raise InvalidParameter(f"oracle {text[:40]!r} is not registered; ask for one of {', '.join(ORACLES)}")
    return said


def _goal(message: Message, *, needed: bool) -> list[str]:
    if message.get("units") is not None:
        return [f"--units={_whole(message, 'units', _MOST_UNITS)}"]
    if message.get("seconds") is None and not needed:
        return []
    seconds = part_of(message, "seconds", float)
    if not 0.0 < seconds <= _MOST_SECONDS:
        raise InvalidParameter(f"{seconds:g} s; give a time above 0 and up to {_MOST_SECONDS:g} s")
    return [f"--budget={seconds:f}"]


def _seed(message: Message) -> str:
    """A seed, as digits: a browser's numbers cannot hold all of them."""
    seed: str = part_of(message, "seed", str)
    if not (seed.isascii() and seed.isdigit() and int(seed[:40]) < 1 << 64):
        raise InvalidParameter(f"seed={seed[:40]!r} is no whole number from 0 to 2**64 - 1; give one")
    return seed


def _whole(message: Message, name: str, most: int) -> int:
    value: int = part_of(message, name, int)
    if not 1 <= value <= most:
        raise InvalidParameter(f"{name} is {value}; give a whole number from 1 to {most}")
    return value
