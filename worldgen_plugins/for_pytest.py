"""The pytest plug-in: worlds as test parameters, stored failures as tests, failing worlds kept.

It is loaded wherever pytest runs, so anything that needs NumPy is imported only when a test uses
it.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fuzz.regression.fixed import RegressionRun
    from sim.episode import Episode
    from worldgen.world import World

__all__ = ["FailureFile", "FailureTest", "worldgen_episode", "worldgen_world"]

EXPECTATIONS = ("fixed", "confirmed")
_ENDINGS = (".grid", ".grid.gz")
_MARK = (
    "worldgen(*, family, controller=None, count=10, seed=0, **parameters): run the test once for "
    "each of count worlds of a family (or of several), with consecutive seeds; the test takes the "
    "fixture worldgen_world, or worldgen_episode for the controller's run"
)


@dataclass(frozen=True)
class _Settings:
    """The plug-in's options, from the command line or else from the ini file."""

    corpora: tuple[Path, ...]
    expect: str
    controller: str | None


@dataclass(frozen=True)
class _Case:
    """One world that a mark requests."""

    family: str
    seed: int
    controller: str | None
    parameters: Mapping[str, Any] = field(default_factory=dict)


_SETTINGS = pytest.StashKey[_Settings]()
_SEEN: pytest.StashKey[RegressionRun] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options and their ini equivalents."""
    group = parser.getgroup("worldgen", "worldgen: worlds and stored failures")
    group.addoption(
        "--worldgen-corpus",
        action="append",
        metavar="DIR",
        help=(
            "Collect each .grid file in this folder and its subfolders as a test; may be repeated."
        ),
    )
    group.addoption(
        "--worldgen-expect",
        choices=EXPECTATIONS,
        help="Requirement on a stored failure: fixed (the robot now arrives; the default), or "
        "confirmed (it replays with the same verdict, evidence and digest).",
    )
    group.addoption(
        "--worldgen-controller",
        metavar="NAME",
        help=(
            "Run this controller in stored failures instead of their own, and in marked tests that "
            "name none."
        ),
    )
    group.addoption(
        "--worldgen-artifacts",
        metavar="DIR",
        help="Folder for the worlds of failing tests [default: d/worldgen in pytest's cache].",
    )
    parser.addini(
        "worldgen_corpus", "Folders as in --worldgen-corpus, for runs without a path.", type="paths"
    )
    parser.addini("worldgen_expect", "Same as --worldgen-expect: fixed or confirmed.", default="")
    parser.addini("worldgen_controller", "Same as --worldgen-controller.", default="")
    parser.addini(
        "worldgen_artifacts",
        "Same as --worldgen-artifacts, relative to the root directory.",
        default="",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Read the options, and collect the corpora too."""
    config.addinivalue_line("markers", _MARK)
    # The code there is trusted, as conftest.py is (worldgen.plugins.trust). This process reads it
    # from its environment, because a run without worlds imports nothing of worldgen.
    os.environ["WORLDGEN_PYTEST_ROOT"] = f"{os.getpid()}:{config.rootpath}"
    options = config.option
    given = [config.invocation_params.dir / folder for folder in options.worldgen_corpus or ()]
    expect = options.worldgen_expect or config.getini("worldgen_expect") or EXPECTATIONS[0]
    if expect not in EXPECTATIONS:
        raise pytest.UsageError(
            f"worldgen_expect = {expect!r} is not valid; write fixed or confirmed"
        )
    usual: Iterable[Path] = config.getini("worldgen_corpus")
    corpora = tuple(Path(folder).resolve() for folder in (given or usual))
    for folder in corpora:
        if not folder.is_dir():
            raise pytest.UsageError(
                f"the corpus {folder} is not a folder; create it, or use another --worldgen-corpus"
            )
    controller = options.worldgen_controller or config.getini("worldgen_controller") or None
    config.stash[_SETTINGS] = _Settings(corpora, expect, controller)

    # Corpora from the ini file are collected only if the command line names no paths.
    if given or config.args_source is not pytest.Config.ArgsSource.ARGS:
        config.args += [str(folder) for folder in corpora if str(folder) not in config.args]


def pytest_report_header(config: pytest.Config) -> str | None:
    """Return a line that names the corpora and what is expected of them."""
    settings = config.stash[_SETTINGS]
    if not settings.corpora:
        return None
    who = f", controller {settings.controller}" if settings.controller else ""
    return f"worldgen: {', '.join(map(str, settings.corpora))}, expected: {settings.expect}{who}"


# Stored failures


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> FailureFile | None:
    """Collect world files in a corpus, and those named on the command line."""
    if not file_path.name.endswith(_ENDINGS):
        return None
    corpora = parent.config.stash[_SETTINGS].corpora
    if parent.session.isinitpath(file_path) or any(
        file_path.is_relative_to(folder) for folder in corpora
    ):
        return FailureFile.from_parent(parent, path=file_path)
    return None


class FailureFile(pytest.File):
    """A stored failure, or a world; it has one test."""

    def collect(self) -> Iterable[FailureTest]:
        """Yield the test, whose name is the expectation."""
        yield FailureTest.from_parent(self, name=self.config.stash[_SETTINGS].expect)


class NotAsExpected(Exception):
    """A stored failure does not meet the expectation.

    The message gives the reason, without control sequences that could affect a terminal.
    """

    def __init__(self, reason: object) -> None:
        from worldgen.support.plain_text import printed

        super().__init__(printed(str(reason)))


class FailureTest(pytest.Item):
    """Runs the controller in the file's world, and checks the outcome against the expectation."""

    def runtest(self) -> None:
        """Run the test.

        Raises:
            NotAsExpected: If the failure is not fixed, or not confirmed.
        """
        from worldgen.errors import WorldgenError
        from worldgen.plugins.own_packages import check_hidden

        try:
            check_hidden()
        except WorldgenError as error:
            raise NotAsExpected(error) from error
        from fuzz.regression.checks import check

        settings = self.config.stash[_SETTINGS]
        try:
            outcome = check(self.path, settings.expect, settings.controller)
        except WorldgenError as error:
            raise NotAsExpected(error) from error
        if outcome.reason:
            self.stash[_SEEN] = outcome.seen
            raise NotAsExpected(outcome.reason)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return only the reason, without a traceback through this program."""
        if isinstance(excinfo.value, NotAsExpected):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return the file and a title for the report."""
        return self.path, None, f"{self.path.name} is {self.name}"


# Marked tests


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrise a test over the worlds of its mark, which are made when the tests run."""
    mark = metafunc.definition.get_closest_marker("worldgen")
    wants = "worldgen_world" in metafunc.fixturenames
    test = metafunc.definition.nodeid
    if mark is None and wants:
        raise pytest.Collector.CollectError(
            f"{test} takes a worldgen fixture but does not name a family of worlds; add "
            '@pytest.mark.worldgen(family="trap")'
        )
    if mark is None or not wants:
        if mark in metafunc.definition.own_markers:
            raise pytest.Collector.CollectError(
                f"{test} is marked worldgen but takes no world; add the argument worldgen_world or "
                f"worldgen_episode"
            )
        return

    # A mark's mistakes are reported as errors of collection, with the test's name.
    try:
        cases = _cases(mark, metafunc.config.stash[_SETTINGS].controller)
    except (TypeError, ValueError) as error:
        raise pytest.Collector.CollectError(f"{test}: {error}") from error
    metafunc.parametrize(
        "worldgen_world",
        cases,
        indirect=True,
        ids=[f"{Path(case.family).name}-{case.seed}" for case in cases],
    )


def _cases(mark: pytest.Mark, usual: str | None) -> list[_Case]:
    # Check the mark by hand: pytest passes it on unread, and a typo must not go unnoticed.
    if mark.args:
        raise TypeError(
            f"the mark worldgen takes keyword arguments only, not {mark.args[0]!r}; write "
            f"family={mark.args[0]!r}"
        )
    given = dict(mark.kwargs)
    family = given.pop("family", None)
    count = given.pop("count", 10)
    seed = given.pop("seed", 0)
    controller = given.pop("controller", None) or usual
    if not (controller is None or isinstance(controller, str)):
        raise TypeError(
            f"controller={controller!r} is not a name; write one, such as package.module:name or "
            f"./file.py:name"
        )
    families: Sequence[object] = [family] if isinstance(family, str) else family or ()
    if not families or not all(isinstance(name, str) for name in families):
        raise TypeError(
            f'family={family!r} does not name a family; write family="trap", or a list of names'
        )
    for name, value, least in (("count", count, 1), ("seed", seed, 0)):
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise ValueError(f"{name}={value!r} is not a whole number from {least}; use one")
    # Each family gets the same seeds, so its test names don't depend on the other families.
    return [
        _Case(str(name), seed + k, controller, given) for name in families for k in range(count)
    ]


@pytest.fixture
def worldgen_world(request: pytest.FixtureRequest) -> World:
    """Return a world of the mark's family, with a witness that its target can be reached."""
    # Import late: pytest loads this plugin in every run, including those without a marked test.
    from worldgen.errors import WorldgenError
    from worldgen.generation import generate
    from worldgen.plugins.own_packages import check_hidden

    case: _Case = request.param
    try:
        check_hidden()
        world = generate(case.family, case.seed, **case.parameters)
    except WorldgenError as error:
        pytest.fail(str(error), pytrace=False)
    from fuzz.regression.fixed import RegressionRun

    # If the test fails, its report shows how to run this world again.
    request.node.stash[_SEEN] = RegressionRun(world)
    return world


@pytest.fixture
def worldgen_episode(request: pytest.FixtureRequest, worldgen_world: World) -> Episode:
    """Return the recorded run of the mark's controller in the world; its seed is the world's."""
    from fuzz.regression.checks import run
    from worldgen.errors import WorldgenError

    case: _Case = request.node.callspec.params["worldgen_world"]
    # Neither the mark nor the command line names a controller.
    if case.controller is None:
        pytest.fail(
            "the test takes worldgen_episode, but no controller is given; add "
            'controller="./mine.py:Robot" to the mark, or use --worldgen-controller',
            pytrace=False,
        )
    try:
        seen, episode = run(worldgen_world, case.controller, case.seed)
    except WorldgenError as error:
        pytest.fail(str(error), pytrace=False)
    request.node.stash[_SEEN] = seen
    return episode


# Reports


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add to a failing test's report the picture, the stored world, and the line to replay it."""
    report = yield
    seen = item.stash.get(_SEEN, None)
    if seen is not None and report.failed and report.when == "call":
        from fuzz.regression.checks import tell

        folder = _artifacts(item.config)
        told = tell(seen, None if folder is None else folder / _artifact_name(item))
        report.sections.append(("worldgen", told.text))
        properties = [(f"worldgen.{name}", value) for name, value in told.properties.items()]
        report.user_properties += properties
        # JUnit reads the properties of the teardown's report, which copies the item's.
        item.user_properties += properties
    return report


def _artifacts(config: pytest.Config) -> Path | None:
    """Return the folder for failing worlds; ``None`` if none is given and pytest has no cache."""
    if config.option.worldgen_artifacts:
        return config.invocation_params.dir / str(config.option.worldgen_artifacts)
    if config.getini("worldgen_artifacts"):
        return config.rootpath / str(config.getini("worldgen_artifacts"))
    cache = getattr(config, "cache", None)
    return None if cache is None else Path(cache.mkdir("worldgen"))


def _artifact_name(item: pytest.Item) -> str:
    """Return a file name that people recognise and that no other test has."""
    readable = re.sub(r"[^A-Za-z0-9.]+", "-", f"{item.path.stem}-{item.name}")[-80:].strip("-")
    return f"{readable}-{hashlib.sha256(item.nodeid.encode()).hexdigest()[:8]}.grid"
