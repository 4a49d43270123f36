"""Every message between page and server: the requests are one tagged union, decoded here.

A request's class declares its fields with their limits, and the process that answers it. Anything
else in a message is refused. ``python -m build_tools.page_types`` writes these types to
``page/messages.d.ts``, against which the page's scripts are checked.

Lengths are in m and times in s, from the grid's lower-left corner; headings are in rad.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal, TypeAlias, TypeVar, Union

import msgspec
from msgspec import Meta, Struct

from fuzz.overview.answer import CampaignAnswer
from fuzz.studio.requests import limits
from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.support.plain_text import quote
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED

PROTOCOL = 4
"""Increased whenever an older page would not understand the server."""
SUBPROTOCOL = "worldgen-studio"
FULL = 4000
"""WebSocket code that closes a connection too many; its reason is a sentence for the page."""

LARGEST_EXACT = 2**53 - 1
"""Largest whole number that the page's scripts hold exactly."""

T = TypeVar("T")
SendPart: TypeAlias = Callable[[T], None]
"""Sends a part of an answer to the page before the rest is known."""


class Seed(int):
    """A 64-bit number; sent as digits, because a browser's numbers cannot hold it."""


# Tables of the campaign store, and those that fuzz.player makes, with their types in TypeScript. Both
# would take long to import.
Budget = Annotated[dict[str, Any], Meta(title="Budget")]
StrategyYields = Annotated[list[dict[str, Any]], Meta(title="StrategyYield[]")]
DrawnWorld = Annotated[dict[str, Any] | None, Meta(title="DrawnWorld")]
DrawnRun = Annotated[dict[str, Any] | None, Meta(title="DrawnRun | null")]
Sensors = Annotated[dict[str, Any] | None, Meta(title="Sensors | null")]
FlowChart = Annotated[dict[str, Any] | None, Meta(title="FlowChart | null")]
OtherRobots = Annotated[list[dict[str, Any]], Meta(title="OtherRobot[]")]
OtherEnds = Annotated[list[dict[str, Any]], Meta(title="OtherEnds[]")]
Witness = Annotated[dict[str, Any] | None, Meta(title="PackedWitness | null")]
Frames = Annotated[list[dict[str, Any]], Meta(title="Frame[]")]
Cells = Annotated[list[Any], Meta(title="CellPlace[]")]
Triple: TypeAlias = tuple[float, float, float]

# A column or row, which may be outside the grid but not absurdly far.
_Cell = Annotated[int, Meta(ge=-(1 << 20), le=1 << 20)]
_Names = Annotated[list[str], Meta(min_length=1, max_length=limits.MOST_ROBOTS)]


class Events(Struct):
    """Changes of cells, in columns; state 0 is free, 1 solid, 2 burning."""

    times: Annotated[list[float], Meta(max_length=limits.MOST_EVENTS)]
    ix: list[_Cell]
    iy: list[_Cell]
    state: list[Annotated[int, Meta(ge=0, le=2)]]


class RobotEnds(Struct):
    """Start, target and radius of a robot after the first; shown, but not edited."""

    start: Triple
    target: Triple
    radius: float


class WorldMessage(Struct):
    """A world as the page edits it, without its proof.

    Args:
        cells: Bits, the first in the lowest bit, row by row from the lowest y.
        start: x, y, heading.
        target: x, y, radius.
        others: The robots after the first.
        source: Text of the file from which it was opened. A world that still equals that one is
            saved, run and exported with its proof, provenance and failure.
    """

    width: Annotated[int, Meta(ge=1)]
    height: Annotated[int, Meta(ge=1)]
    cells: bytes
    cell_size: float
    robot_radius: float
    robot_speed: float
    start: Triple
    target: Triple
    events: Events | None = None
    others: list[RobotEnds] = []
    source: str | None = None


# Requests


class Request(Struct, kw_only=True, forbid_unknown_fields=True, tag_field="do", tag=str.lower):
    """A message from the page, with its own number."""

    id: Annotated[int, Meta(ge=0, le=LARGEST_EXACT)]

    worker: ClassVar[str] = "files"
    """The process that answers it.

    Saving is never interrupted, a long search for a proof does not delay a run, and anything that
    is slow to start can be stopped while it starts.
    """
    is_replaced: ClassVar[bool] = False
    """Whether only the newest of its kind counts."""
    can_end: ClassVar[bool] = False
    """Whether it can be ended: it runs controllers or takes long, and writes nothing."""

    @property
    def do(self) -> str:
        """The name of its kind."""
        return str(self.__struct_config__.tag)


class Cancel(Request):
    """End another request, which is then answered by ``ended``."""

    of: Annotated[int, Meta(ge=0, le=LARGEST_EXACT)]


class Hello(Request):
    """Return everything that the page offers as a choice."""

    can_end = True


class Files(Request):
    """Return the files in the folder that can be opened."""


class Open(Request):
    """Return a world of the folder."""

    name: str


class Before(Request):
    """Return the original of a failure in the folder, before shrinking."""

    worker = "pictures"
    can_end = True
    name: str


class Save(Request, kw_only=True):
    """Write a world to the folder, with its file's proof or else a new one.

    Args:
        replaces: Digest of a file that may be replaced.
    """

    name: str
    world: WorldMessage
    overwrite: bool
    replaces: str | None = None


class NamedFile(Struct, forbid_unknown_fields=True):
    """A file of the browser: dropped on the page, or to be kept."""

    name: str
    data: bytes


class Bring(Request, kw_only=True):
    """Import a map of another program: from the folder, or dropped with its companions.

    Args:
        radius: Radius of the robot.
        row: Problem of its scenario, from 1; 0 for none. The only one of a scenario is always used.
        seed: Seed of the places, if the map has none.
    """

    name: str | None = None
    files: Annotated[list[NamedFile], Meta(min_length=1, max_length=limits.MOST_FILES)] | None = (
        None
    )
    format: str | None = None
    options: dict[str, Any] = {}
    radius: float | None = None
    row: Annotated[int, Meta(ge=0)] | None = None
    seed: Seed | None = None


class Export(Request, kw_only=True):
    """Return a world in another program's format.

    Args:
        keep: Write it to the folder instead.
        at: Time at which to take the cells of a world that changes.
    """

    name: str
    world: WorldMessage
    format: str
    keep: bool
    overwrite: bool = False
    options: dict[str, Any] = {}
    at: float | None = None
    origin: tuple[float, float] | None = None
    sidecar: bool = True


class Decide(Request):
    """Decide if the target can be reached; for several robots, all together."""

    worker = "proofs"
    is_replaced = can_end = True
    world: WorldMessage


class Widest(Request):
    """Return the largest radius that fits through."""

    worker = "widths"
    is_replaced = can_end = True
    world: WorldMessage


class Signal(Request):
    """Return the signal that the thesis's robot reads, cell by cell."""

    worker = "making"
    is_replaced = can_end = True
    world: WorldMessage
    noise: bool


class Goal(Request):
    """Return the world with another body and other goals of its robot.

    Args:
        footprint: As the option ``--footprint``; empty for the disc, and so for the other texts.
        heading: As ``--target-heading``.
        arrival: As ``--arrival``.
        waypoints: As ``--waypoints``, places only.
    """

    world: WorldMessage
    footprint: str
    heading: str
    arrival: str
    waypoints: str


class Measure(Request):
    """Return the difficulty of a world by every applicable metric."""

    worker = "widths"
    is_replaced = can_end = True
    world: WorldMessage


class Generate(Request, kw_only=True):
    """Return a world of a family; with a difficulty or a condition, search for one."""

    worker = "making"
    is_replaced = can_end = True
    family: str
    seed: Seed
    parameters: dict[str, Any]
    difficulty: float | None = None
    where: str | None = None


class Preview(Request):
    """Return a small world of a family, as an example."""

    worker = "looks"
    family: str


class Shift(Request):
    """Return the world with walls that move, as in the thesis's world shifter."""

    worker = "making"
    world: WorldMessage
    seed: Seed


class RunRequest(Request, kw_only=True):
    """Settings of runs.

    Args:
        options: Options of the motion model, by name.
        steps: Null for the usual budget.
        still: Ignore the world's changes.
    """

    motion: str
    time_step: float
    seed: int
    options: dict[str, Any]
    steps: int | None = None
    still: bool = False


class Run(RunRequest, kw_only=True):
    """Run controllers in a world, one after another; each result is a part."""

    worker = "runs"
    is_replaced = can_end = True
    world: WorldMessage
    controllers: _Names


class Picture(RunRequest, kw_only=True):
    """Return the same runs as a file.

    Args:
        looked: Number of the robot in front; a drawing shows only this one.
    """

    worker = "pictures"
    can_end = True
    world: WorldMessage
    controllers: _Names
    kind: Literal["gif", "svg", "html"]
    title: str
    looked: Annotated[int, Meta(ge=0)]


class Drive(RunRequest, kw_only=True):
    """Run a robot by the user's commands from the start.

    The page asks again with more commands, several times a second. That is simple, and the run is
    as exact and as repeatable as any other.

    Args:
        commands: Number of steps, share of the top speed, and turn rate in rad/s.
    """

    worker = "looks"
    can_end = True
    world: WorldMessage
    commands: Annotated[
        list[
            tuple[
                Annotated[int, Meta(ge=1, le=limits.MOST_DRIVEN)],
                Annotated[float, Meta(ge=-1.0, le=1.0)],
                Annotated[float, Meta(ge=-limits.FASTEST_TURN, le=limits.FASTEST_TURN)],
            ]
        ],
        Meta(min_length=1),
    ]


class Check(RunRequest, kw_only=True):
    """Check that a controller may run under this name with its options."""

    worker = "looks"
    controller: str


class Core(Request):
    """Return the core with which the page judges worlds itself; null if there is none here."""

    worker = "looks"


class Recipe(RunRequest, kw_only=True):
    """Return what the page needs to run a controller itself, in any world of this size and robot."""

    worker = "looks"
    is_replaced = True
    world: WorldMessage
    controller: str


class ComparedWorld(Struct, forbid_unknown_fields=True):
    """A world of a comparison: sent along, a file of the folder, or made by a family."""

    world: WorldMessage | None = None
    file: str | None = None
    family: str | None = None
    seed: Seed | None = None


class Compare(RunRequest, kw_only=True):
    """Run each controller in each world; each cell is a part.

    Args:
        seeds: Number of runs of a robot that uses chance.
    """

    worker = "tables"
    is_replaced = can_end = True
    controllers: Annotated[list[str], Meta(min_length=1, max_length=limits.MOST_COMPARED)]
    worlds: Annotated[list[ComparedWorld], Meta(min_length=1, max_length=limits.MOST_WORLDS)]
    seeds: Annotated[int, Meta(ge=1, le=limits.MOST_SEEDS)]


class Edits(Request):
    """Report the files whose code the studio runs, at first and after each edit."""

    worker = "server"
    is_replaced = can_end = True


class Campaigns(Request):
    """Return the folder's campaigns, and the folders and archives that hold worlds."""

    worker = "walls"


class CampaignBudget(Request, kw_only=True):
    """A campaign's folder, and what it may spend.

    Args:
        known: Count causes in the folder for known failures, but keep only others.
        baseline: More folders of known failures.
    """

    worker = "campaigns"
    folder: str
    units: Annotated[int, Meta(ge=1, le=limits.MOST_UNITS)] | None = None
    seconds: Annotated[float, Meta(gt=0.0, le=limits.MOST_SECONDS)] | None = None
    workers: Annotated[int, Meta(ge=1, le=limits.MOST_WORKERS)] | None = None
    known: bool = False
    baseline: list[str] = []


class Begin(CampaignBudget, kw_only=True):
    """Begin a campaign, or resume the one in its folder.

    Args:
        strategies: Strategies and families.
        world: The drawn map to search on.
        world_name: The file of that map.
    """

    controller: str
    motion: str
    strategies: list[str] = []
    world: WorldMessage | None = None
    world_name: str | None = None
    seed: Seed | None = None
    robots: int | None = None
    time_step: float | None = None
    examples: int | None = None
    epoch: int | None = None
    oracles: list[str] = []
    vary: list[str] = []
    shrink: bool | None = None


class Command(Begin):
    """Return the command that begins the same campaign at a terminal."""


class Resume(CampaignBudget):
    """Resume the campaign in a folder."""


class Watch(Request):
    """Report a campaign's state whenever it has changed, until it ends."""

    worker = "server"
    is_replaced = can_end = True
    folder: str


class Stop(Request):
    """Stop a campaign, also one that has not begun yet."""

    worker = "server"
    folder: str


class Elite(Request):
    """Return the simplest world in a cell of a campaign's archive."""

    worker = "looks"
    folder: str
    i: int
    j: int


class Failures(Request):
    """Return the failures in and below a folder, "" for the opened one, or in an archive."""

    worker = "walls"
    folder: str


class Look(Request):
    """Return a failure's world and run, to be drawn, and a description of what happened."""

    worker = "looks"
    can_end = True
    name: str


class Snippet(Request):
    """Return a failure as the source of a test."""

    worker = "looks"
    name: str


class Know(Request):
    """Mark a failure's cause as known, or unmark it."""

    worker = "walls"
    name: str
    known: bool


REQUESTS: dict[str, type[Request]] = {
    str(kind.__struct_config__.tag): kind
    for kind in (
        Hello, Files, Open, Before, Save, Bring, Export, Decide, Widest, Signal, Goal, Measure, Generate,
        Preview, Shift, Run, Picture, Drive, Check, Core, Recipe, Compare, Edits, Campaigns, Begin, Command,
        Resume, Watch, Stop, Elite, Failures, Look, Snippet, Know, Cancel,
    )
}  # fmt: skip
"""Every kind of request by its name."""


# Answers and their parts


class Refusal(Struct):
    """An error as data; it does not depend on the wording.

    Args:
        code: Names the rule.
        frames: Where the user's code has failed, the innermost last.
        remedy: By fields and buttons of the page, if possible.
        terminal: Whether the remedy needs a terminal.
        opens: The part of the page with the remedy: ``import`` for the options of the import.
        facts: The values by name; paths in the opened folder are relative to it.
        line: Line of the file, if the error is in one.
    """

    code: str
    problem: str
    remedy: str
    terminal: bool
    opens: str
    facts: dict[str, Any]
    frames: Frames
    line: int | None = None
    source: str | None = None


class Idle(Struct):
    """The parameter ``by`` and its values with which another one has no effect."""

    by: str
    values: list[str]


class ParameterMessage(Struct, kw_only=True):
    """A parameter of a family or format, or an option of a motion model.

    Args:
        kind: Name of its Python type: bool, int, float or str.
        above: Whether ``low`` itself is too small.
        chosen: A number that is allowed in addition.
        bounds: The bounds in words.
    """

    name: str
    default: Any
    kind: str
    choices: list[str]
    low: float | None
    high: float | None
    above: bool
    chosen: float | None
    bounds: str
    unit: str
    group: str
    help: str
    idle: Idle | None = None


class FamilyMessage(Struct):
    """A registered family."""

    name: str
    about: str
    changes: bool
    parameters: list[ParameterMessage]


class OfferedController(Struct, kw_only=True):
    """A controller, with the motion model that it usually runs under.

    Args:
        also: Another registered name of the same controller.
        named: Whether it was named at the start.
        fault: Why it cannot be loaded.
    """

    name: str
    named: bool
    thesis: bool = False
    lattice: bool = True
    motion: str = "swept"
    also: str = ""
    fault: Refusal | None = None


class MotionMessage(Struct):
    """A motion model."""

    name: str
    about: str
    thesis: bool
    options: list[ParameterMessage]


class FormatMessage(Struct):
    """A format that can be read or written."""

    name: str
    about: str
    suffixes: list[str]
    reads: bool
    writes: bool
    changes: bool
    options: list[ParameterMessage]
    read_options: list[ParameterMessage]


class OptionHelp(Struct):
    """Help text and default of an option of ``worldgen fuzz``."""

    help: str
    default: str | int | float | None


class Offered(Struct):
    """Everything that the page offers as a choice.

    Args:
        controllers: Those named at the start first.
        motion: The default.
        known: Name of the folder of known failures.
    """

    families: list[FamilyMessage]
    controllers: list[OfferedController]
    motions: list[MotionMessage]
    formats: list[FormatMessage]
    motion: str
    time_step: float
    strategies: list[str]
    oracles: list[str]
    cores: int
    known: str
    options: dict[str, OptionHelp]


class ListedFile(Struct):
    """A file that can be opened.

    Args:
        found: Whether a campaign has found it.
    """

    name: str
    bytes: int
    world: bool
    found: bool


class RecordedRun(Struct):
    """A recorded run: a failure's, or that of an archive's cell."""

    controller: str
    motion: str
    seed: int
    parameters: dict[str, Any]
    verdict: str = ""
    digest: str = ""


class OpenedMessage(Struct, kw_only=True):
    """A world with the facts in its file.

    Args:
        made: A sentence on its origin.
        failure: The record of a failure's file.
        file: Digest of the file's bytes, or null if the world was not read from the folder.
        name: The file's name, once it is saved.
        main: Name of an imported map among its files.
        format: Format of an imported map.
        rows: Problems in a map's scenario; ``row`` is the one used.
        notes: Remarks of the import.
        runs: What a campaign ran in the world, unless it varies that.
    """

    world: WorldMessage
    made: str | None = None
    failure: RecordedRun | None = None
    file: str | None = None
    name: str = ""
    main: str = ""
    format: str | None = None
    rows: int = 0
    row: int | None = None
    notes: list[str] = []
    runs: RecordedRun | None = None


class FoundRun(Struct):
    """A failure as it was found."""

    words: str
    world: DrawnWorld
    sensors: Sensors
    run: DrawnRun
    number: int | None = None
    others: OtherRobots = []


class Exported(Struct, kw_only=True):
    """An export.

    Args:
        written: Names in the folder, if it is kept there.
        files: Else one file, which is a .zip of those ``inside`` if the format has several.
    """

    lost: list[str]
    notes: list[str]
    written: list[str] = []
    files: list[NamedFile] = []
    inside: list[str] = []


class ProofMessage(Struct, kw_only=True, omit_defaults=True):
    """A decision with its proof.

    Args:
        length: Length of the path; of several robots, the sum.
        clearance: Of the witness, or how much too wide the robot is for the cut.
        ring: Number of cells of the cut, if they form a ring.
        others: Ends and witness of each robot after the first.
    """

    result: Annotated[str, Meta(title='"reachable" | "blocked" | "undecided"')]
    reason: str
    length: float = 0.0
    duration: float = 0.0
    clearance: float = 0.0
    witness: Witness = None
    cut: Cells | None = None
    ring: int | None = None
    others: OtherEnds = []


class Metric(Struct):
    """A world's value of a metric."""

    name: str
    value: float
    unit: str
    meaning: str


class Progress(Struct):
    """The worlds tried or files read so far; of an archive, their number is unknown."""

    done: int
    of: int | None


class RunBegins(Struct):
    """The world of a run.

    Args:
        impossible: A sentence if it is impossible or undecided that all robots arrive.
    """

    world: DrawnWorld
    impossible: str


class RobotMessage(Struct, kw_only=True):
    """A robot's run, as the player takes it.

    Args:
        why: Evidence for the verdict, in words.
        frames: Where the controller crashed.
    """

    name: str
    verdict: str
    why: str
    frames: Frames
    steps: int
    time: float
    path: float
    collisions: int
    digest: str
    run: DrawnRun
    others: OtherRobots
    sensors: Sensors


class RanRobot(RobotMessage, kw_only=True):
    """A robot's run by its number, with the flow chart of its behaviours."""

    number: int
    arbitration: FlowChart


class RobotFault(Struct):
    """Why a robot did not run."""

    number: int
    name: str
    error: Refusal


class DrivenRobot(RobotMessage, kw_only=True):
    """The run of the robot that the user drives.

    Args:
        motion: The motion model, which is swept instead of the thesis's.
        ended: Whether the world ended the run before the commands did.
    """

    motion: str
    ended: bool


class RowPart(Struct, kw_only=True, omit_defaults=True):
    """A row's size, then what its cells cannot show: a fault, or the best columns."""

    row: int
    width: int = 0
    height: int = 0
    column: int | None = None
    error: Refusal | None = None
    best: list[int] | None = None


class CellPart(Struct, kw_only=True):
    """A cell of a comparison.

    Args:
        detail: What is known beyond the verdict, such as a loop's period.
        time: Null if it never arrives.
        seed: Seed of the run to play.
    """

    row: int
    column: int
    verdict: str
    detail: str
    steps: float
    time: float | None
    runs: int
    reached: int
    seed: int


class ColumnTotal(Struct):
    """Totals of a controller over the full rows."""

    runs: int
    reached: int
    wins: int
    shared: int
    mean_time: float | None


class ComparisonMessage(Struct):
    """The totals by column, and the number of full rows."""

    totals: list[ColumnTotal]
    rows: int


class CodeFile(Struct):
    """A file whose code the studio runs, and the named controllers that may run it."""

    file: str
    name: str
    digest: str
    controllers: list[str]


class ArchiveMessage(Struct):
    """The archive of behaviours: its two numbers, and index, quality and verdict of each cell."""

    names: list[str]
    edges: list[list[float]]
    cells: list[tuple[int, int, float, str]]


class CampaignState(Struct, kw_only=True):
    """A campaign in numbers.

    Args:
        edited: Whether the controller's file is not the one that the campaign runs.
        activity: What it is doing, or how it ended.
        answer: Empty while it runs.
        shrinking: Failures that are being shrunk, or wait for it.
        failed: Runs that did not arrive in screening.
        elapsed: Seconds of the budget that are used; preparing does not count.
        failures: A text that changes whenever a failure is new or smaller.
        error: Why it gave up.
        conclusion: What it found out, once it has ended.
    """

    folder: str
    running: bool
    controller: str
    edited: bool
    motion: str
    seed: str
    budget: Budget
    failures: str
    activity: Literal[
        "preparing", "searching", "shrinking", "explaining", "stopped", "done", "gave-up"
    ] = "done"
    answer: Literal["", "failures", "clean", "none"] = ""
    answer_reason: str = ""
    shrinking: int = 0
    units: int = 0
    worlds: int = 0
    failed: int = 0
    steps: int = 0
    seconds: float = 0.0
    elapsed: float | None = None
    verdicts: dict[str, int] = {}
    met: dict[str, int] = {}
    known: dict[str, int] = {}
    strategies: StrategyYields = []
    archive: ArchiveMessage | None = None
    error: Refusal | None = None
    conclusion: CampaignAnswer | None = None


class ListedFolder(Struct):
    """A folder that holds worlds, with their number."""

    name: str
    worlds: int


class CampaignList(Struct):
    """The folder's campaigns, running ones first, with those that cannot be read."""

    campaigns: list[CampaignState]
    faults: list[Refusal]
    folders: list[ListedFolder]
    archives: list[str]


class WallFailure(Struct, kw_only=True):
    """A failure of a folder.

    Args:
        group: The name under which it is filed: its cause or, for an error of the controller, the
            reason.
        place: Its place among the folder's failures, the simplest first.
        rank: The place of its cause, the worst first.
        seen: Seconds since 1970.
    """

    name: str
    group: str
    verdict: str
    controller: str
    motion: str
    width: int
    height: int
    solid: int
    events: int
    shrinking: Literal["done", "cut short", "none"]
    digest: str
    place: int
    rank: int
    seen: int
    known: bool


class FailureList(Struct):
    """The failures of a folder, and why some of its files cannot be read."""

    failures: list[WallFailure]
    faults: list[Refusal]


class LookMessage(Struct, kw_only=True):
    """A failure to be drawn, and what happened in words.

    Args:
        sentence: Of its cause, like ``advice``; empty if unknown.
        why: For a cause's example, the changes after which it arrives; ``named`` are their cells.
        same: Whether the run has the digest that was found.
        error: Why it is not run.
        replay: A command.
    """

    world: DrawnWorld
    replay: str
    notes: list[str]
    why: str
    named: Cells
    sentence: str = ""
    advice: str = ""
    words: str = ""
    repeats: str = ""
    same: bool | None = None
    run: DrawnRun = None
    sensors: Sensors = None
    number: int | None = None
    others: OtherRobots = []
    error: Refusal | None = None


class Limits(Struct, frozen=True):
    """The server's limits, so that the page's fields can show what it would refuse.

    Pairs are the smallest and the largest value.

    Args:
        message: Bytes of a message.
        dropped: Bytes of files that are dropped together.
        side: Cells per side.
        fleet: Robots in each world of a campaign.
        compared: Controllers of a comparison.
        seed: Digits.
    """

    message: int = limits.MOST_MESSAGE
    dropped: int = limits.MOST_DROPPED
    side: int = limits.MAX_SIDE
    cells: int = limits.MOST_CELLS
    lengths: tuple[float, float] = limits.LENGTHS
    robots: int = limits.MOST_ROBOTS
    compared: int = limits.MOST_COMPARED
    compared_worlds: int = limits.MOST_WORLDS
    compared_seeds: int = limits.MOST_SEEDS
    steps: int = limits.MOST_STEPS
    time_steps: tuple[float, float] = limits.TIME_STEPS
    seconds: int = limits.MOST_SECONDS
    units: int = limits.MOST_UNITS
    workers: int = limits.MOST_WORKERS
    examples: int = limits.most("examples")
    epoch: int = limits.most("epoch")
    fleet: int = limits.most("robots")
    seed: str = str(MASK64)


class UsualWorld(Struct, frozen=True):
    """Cells and robot of a new world."""

    cell_size: float = DEFAULT_CELL_SIZE
    robot_radius: float = DEFAULT_ROBOT_RADIUS
    robot_speed: float = DEFAULT_ROBOT_SPEED


class Given(Struct):
    """What the page needs to know before it has a connection.

    Args:
        protocol: The version of this page.
        full: WebSocket code for too many connections; the reason is a sentence.
    """

    protocol: int = PROTOCOL
    subprotocol: str = SUBPROTOCOL
    full: int = FULL
    world: UsualWorld = UsualWorld()


class Begins(Struct):
    """The first message of a connection.

    Args:
        folder: The opened folder.
        file: The world to open first.
    """

    folder: str
    file: str | None
    protocol: int = PROTOCOL
    limits: Limits = Limits()


class Reply(Struct, omit_defaults=True):
    """What the server sends about a request: parts, then an answer, an error, or that it ended.

    Args:
        code: With parts of runs, if controllers were named at the start: the digests of the user's
            files whose code the process has loaded, or ``?`` if it was read during an edit.
    """

    id: int
    part: Any = msgspec.UNSET
    answer: Any = msgspec.UNSET
    code: dict[str, str] = {}
    error: Refusal | None = None
    ended: bool = False


def _converted(kind: type, value: Any) -> Any:
    """Return a value as a type of ours."""
    if not (isinstance(value, str) and re.fullmatch("[0-9]{1,20}", value)):
        raise ValueError("Expected the digits of a seed")
    if int(value) > MASK64:
        raise ValueError("Expected a seed from 0 to 2**64 - 1")
    return kind(value)


def _plain(value: Any) -> str:
    """Return a text of a class of ours, such as a name that a file gave, as a plain one."""
    if isinstance(value, str):
        return str(value)
    raise TypeError(f"{type(value).__name__} has no place in a message")


encoded = msgspec.json.Encoder(enc_hook=_plain).encode
"""Returns a message to the page in JSON."""

_DECODER: msgspec.json.Decoder[Request] = msgspec.json.Decoder(
    Union[tuple(REQUESTS.values())],  # noqa: UP007 - of as many types as there are
    dec_hook=_converted,
)
_LONGEST_RULE = 200  # characters; it may quote a name from the message
_FAULT = re.compile(r"(?s)(.*?)(?: - at `\$\.?([^`\s]*)`)?")


def decoded(text: str) -> Request:
    """Return a message from the page.

    Raises:
        InvalidParameter: If it is not JSON, or not a request as its type declares it.
    """
    try:
        return _DECODER.decode(text)
    except msgspec.ValidationError as error:
        rule, place = _FAULT.fullmatch(str(error)).groups(default="")  # type: ignore[union-attr]
        raise InvalidParameter(
            "wrong-message",
            "{place}{value}: {rule}",
            "correct it, or reload the page",
            place=place or "the page's message",
            value=_value_at(text, place),
            rule=rule[:_LONGEST_RULE],
        ) from None
    except (ValueError, RecursionError):
        raise InvalidParameter("not-json", "this is not JSON", "send one object") from None


def _value_at(text: str, place: str) -> str:
    """Return a part of a message, to be quoted after its place; empty if there isn't one."""
    with contextlib.suppress(LookupError, ValueError, TypeError, RecursionError):
        found = msgspec.json.decode(text)
        for step in re.findall(r"[^.[\]]+", place):
            found = found[int(step) if isinstance(found, list) else step]
        return f" = {quote(found)}" if place else ""
    return ""


def number_of(text: str) -> int:
    """Return the number of a request that cannot be decoded; -1 if it has none."""
    try:
        return msgspec.json.decode(text, type=Reply).id
    except (ValueError, RecursionError):
        return -1
