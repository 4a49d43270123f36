"""Campaigns that the page begins, resumes and stops.

Each is a `worldgen fuzz` in its own process, connected to the studio only through its folder. So a
campaign outlives the page and the server, and a campaign begun at a terminal can be watched and
stopped here. A folder may come from elsewhere: a controller or an oracle in a file runs only if it
was named when the studio was started.
"""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY, FolderStore, forget_error, read_error
from fuzz.studio.campaigns.elites import elite_of, runs_in
from fuzz.studio.campaigns.fuzz_arguments import (
    begun,
    check_oracles,
    check_strategies,
    command_line,
    spent,
)
from fuzz.studio.campaigns.state import (
    SAID,
    beginning,
    campaign_state,
    interrupt,
    is_campaign,
    own_folder,
    running_process,
)
from fuzz.studio.requests.folder import KNOWN, MOST_FAILURES, Folder, Opened, answer
from fuzz.studio.requests.messages import opened_message, restored
from fuzz.studio.requests.protocol import (
    Begin,
    CampaignList,
    Campaigns,
    CampaignState,
    Command,
    Elite,
    ListedFolder,
    OpenedMessage,
    Resume,
    SendPart,
)
from fuzz.studio.requests.running import may_run
from sim.motion import MOTIONS
from worldgen.errors import InvalidParameter, OutputError, WorldgenError
from worldgen.files.grid import write_world

# Seconds that a process has to begin: a busy machine may need to compile kernels first.
_BEGINS = 300.0
_ENDS = 2.0  # s to wait for a campaign that was stopped before it had begun
_LOOK = 0.05  # s between checks
# `python -m worldgen`, after a JSON list of the names of code that it may run.
_WITH_NAMES = (
    "import json, sys; from worldgen.cli.main import main; from worldgen.plugins import trust; "
    "trust.restrict(json.loads(sys.argv.pop(1))); main()"
)


# Processes of campaigns begun here, which are waited for once they have ended.
_begun: list[subprocess.Popen[bytes]] = []


@answer.register
def _campaigns(request: Campaigns, opened: Opened, part: object) -> CampaignList:
    folders = _folders(opened.folder)
    states = []
    faults = []
    for name in folders:
        try:
            states += [_state(opened, name)] if _is_campaign(opened.folder, name) else []
        except WorldgenError as error:  # report this one and list the others
            faults.append(opened.folder.refusal(error))
    return CampaignList(
        sorted(states, key=lambda state: (not state.running, state.folder)),
        faults,
        [ListedFolder(name, worlds) for name, worlds in folders.items() if worlds],
        opened.folder.archives(),
    )


@answer.register
def _begin(request: Begin, opened: Opened, part: SendPart[str]) -> CampaignState:
    out = _own(opened.folder, request.folder)
    words = [*_words(request, opened), f"--out={out}"]
    # A drawn map exists only here, so it is passed to the process as a temporary file.
    with tempfile.TemporaryDirectory() as there:
        if request.world is not None:
            fixed = Path(there) / "world.grid"
            write_world(restored(request.world), fixed)
            words.append(f"--world={fixed}")
        _start(out, words, lambda: part(request.folder))
    return _state(opened, request.folder)


@answer.register
def _command(request: Command, opened: Opened, part: object) -> str:
    out = _own(opened.folder, request.folder)
    return command_line(_words(request, opened), request, out, opened.folder)


@answer.register
def _resume(request: Resume, opened: Opened, part: SendPart[str]) -> CampaignState:
    out = _own(opened.folder, request.folder)
    controller = _check_stored(opened, out, request.folder)
    words = [f"--resume={out}", *spent(request, opened.folder)]
    _start(out, words, lambda: part(request.folder), named=[controller])
    return _state(opened, request.folder)


@answer.register
def _elite(request: Elite, opened: Opened, part: object) -> OpenedMessage:
    out = _own(opened.folder, request.folder)
    return opened_message(elite_of(out, request.i, request.j), runs=runs_in(out))


def _words(request: Begin, opened: Opened) -> list[str]:
    """Return the arguments of `worldgen fuzz`, without the fixed map and the folder."""
    if request.units is None and request.seconds is None:
        raise InvalidParameter("no-budget", "the campaign has no budget", "give units or seconds")
    return [*begun(request, opened), *spent(request, opened.folder)]


def _state(opened: Opened, name: str) -> CampaignState:
    return campaign_state(opened.folder.place(name), name, opened.folder.root, opened.named)


def _is_campaign(folder: Folder, name: str) -> bool:
    try:
        return bool(name) and is_campaign(_own(folder, name))
    except InvalidParameter:
        return False


def _own(folder: Folder, name: str) -> Path:
    """Return a folder in the opened one for a campaign of its own."""
    out = own_folder(folder, name)
    if out.is_relative_to(folder.root / KNOWN):
        raise InvalidParameter(
            "folder-is-for-known",
            "{known}/ is reserved for failures that are marked as known",
            "choose another folder",
            known=KNOWN,
        )
    return out


def _check_stored(opened: Opened, out: Path, name: str) -> str:
    """Refuse a campaign that would run code that was not named at the start.

    Its folder may have any origin. Return its controller, the only code of it that may run.
    """
    stored = FolderStore.stored_in(out)
    if stored is None:
        raise InvalidParameter(
            "no-campaign", "{name} has no campaign to resume", "begin one", name=name
        )
    configuration = stored[0].configuration
    # The campaign store may name code in files, which must not run unless the user named it.
    scenario = configuration.get("scenario")
    if not isinstance(scenario, dict) or not may_run(str(scenario.get("controller")), opened.named):
        raise InvalidParameter(
            "not-named",
            "{name} runs a controller that was not named when the studio started",
            "name it when starting: worldgen studio --controller",
            at_terminal=True,
            name=name,
        )
    if scenario.get("motion") not in MOTIONS.names():
        raise InvalidParameter(
            "not-registered",
            "{name} uses a motion model from a file",
            "resume it at a terminal",
            name=name,
        )
    check_strategies(map(str, configuration.get("families") or ()))
    check_oracles(map(str, configuration.get("oracles") or ()))
    return str(scenario["controller"])


def _start(
    out: Path, words: list[str], started: Callable[[], None], *, named: Sequence[str] = ()
) -> None:
    """Start a campaign's process and wait until it has begun.

    Args:
        out: The campaign's folder.
        words: Arguments of the process other than the folder.
        started: Called when it can be stopped.
        named: Names of code that it may run although the words do not contain them.

    Raises:
        OutputError: If it does not begin; with the process's message.
    """
    # Two campaigns must not share a folder.
    if running_process(out) is not None:
        raise OutputError(
            "campaign-is-running",
            "the campaign in {name} is already running",
            "stop it first",
            name=out.name,
        )
    # Remember the folders created here, so that they can be removed if it does not begin.
    memory = out / MEMORY
    made = [folder for folder in (memory, out, *out.parents) if not folder.exists()]
    # Start the command, and wait until it has begun or refused.
    with contextlib.ExitStack() as stack:
        try:
            memory.mkdir(parents=True, exist_ok=True)
            forget_error(out)
            mark = stack.enter_context(beginning(memory))
            with (memory / SAID).open("wb") as stderr:
                process = _process(fuzz_command(words, named), stderr)
        except OSError as error:
            raise OutputError(
                "unwritable",
                "{name} cannot be written: {reason}",
                "choose another folder",
                name=out.name,
                reason=error.strerror or str(error),
            ) from error
        _begun[:] = [one for one in _begun if one.poll() is None] + [process]
        started()
        why_not = _wait_until_begun(process, out, mark)
        if why_not is None and not mark.exists():
            interrupt(process.pid)  # it was stopped while it was starting
    if why_not is None:
        return
    # It did not begin, so leave everything unchanged.
    (memory / SAID).unlink(missing_ok=True)
    forget_error(out)
    for folder in made:
        with contextlib.suppress(OSError):  # not empty
            folder.rmdir()
    raise why_not


def _wait_until_begun(
    process: subprocess.Popen[bytes], out: Path, mark: Path
) -> WorldgenError | None:
    """Return why a campaign's process did not begin; ``None`` as soon as it has."""
    until = time.monotonic() + _BEGINS
    while process.poll() is None:
        if running_process(out) == process.pid and is_campaign(out):
            return None
        if time.monotonic() > until:
            process.kill()
            return OutputError(
                "slow-to-begin",
                "the campaign has not begun within {seconds:g} s",
                "try it at a terminal",
                seconds=_BEGINS,
            )
        if not mark.exists():
            _end(process)
            return _stopped()
        time.sleep(_LOOK)
    # It has already ended: normally, with a recorded error, or unexpectedly.
    if process.returncode in (0, 1, 4, 130):
        return None if is_campaign(out) else _stopped()
    return read_error(out) or _last_words(process.returncode, out / MEMORY / SAID)


def fuzz_command(words: Sequence[str], named: Sequence[str] = ()) -> list[str]:
    """Return the command line of a campaign's process.

    Args:
        words: Arguments of ``worldgen fuzz``.
        named: Names of code that it may run although the words do not contain them. ``--trust``
            would let it run all code that is in its folder by then.
    """
    begun = ["-c", _WITH_NAMES, json.dumps(list(named))] if named else ["-m", "worldgen"]
    return [sys.executable, *_flags(), *begun, "fuzz", "--json", *words]


def _flags() -> tuple[str, ...]:
    """Return Python's flag against modules in the current folder, unless this process has it too.

    The folder may hold a stranger's files.
    """
    return () if {"", str(Path.cwd())} & {*sys.path} else ("-P",)


def _stopped() -> OutputError:
    return OutputError("campaign-stopped", "the campaign was stopped before it began")


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process as Ctrl-C would; by force if that takes too long."""
    interrupt(process.pid)
    try:
        process.wait(_ENDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _process(command: list[str], stderr: Any) -> subprocess.Popen[bytes]:
    """Start a process that a Ctrl-C at the server's terminal does not reach, but ours does."""
    # A signal that is ignored here would be ignored there too.
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            start_new_session=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)


def _last_words(status: int, path: Path) -> WorldgenError:
    """Return the error of a process that ended without recording why.

    Either it has an internal error, or it was killed.
    """
    lines = [
        line.strip() for line in path.read_text("utf-8", "replace").splitlines() if line.strip()
    ]
    return OutputError(
        "ended-without-record",
        "the campaign's process ended with exit code {status}: {said}",
        "try it at a terminal",
        status=status,
        said=lines[-1] if lines else "it wrote nothing",
    )


def _folders(folder: Folder) -> dict[str, int]:
    """Return the folders below the opened one, with the number of worlds in and below each.

    "" stands for the opened folder itself.
    """
    counts: dict[str, int] = {"": 0}
    for entry in folder.files(most=MOST_FAILURES):
        if entry.world:
            parts = entry.name.split("/")[:-1]
            for depth in range(len(parts) + 1):
                name = "/".join(parts[:depth])
                counts[name] = counts.get(name, 0) + 1
    for name in folder.folders():
        counts.setdefault(name, 0)
    return dict(sorted(counts.items()))
