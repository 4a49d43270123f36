"""Set up a project's CI: settings, a corpus of known failures, and a job that finds new ones."""

from __future__ import annotations

import contextlib
import importlib.resources
import json
import shlex
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from worldgen.errors import FormatError, InvalidParameter, OutputError
from worldgen.files.whole import check_writable, write_bytes
from worldgen.plugins.installation import origin, requirement

SEED = 1
"""Seed of every pull request's search, so that equal changes give equal results."""

CORPUS = Path("worldgen-corpus")
KNOWN = CORPUS / "known"
FIXED = CORPUS / "fixed"

_PLACEHOLDER = "worldgen @ git+https://YOUR-HOST/worldgen@COMMIT"

_CORPUS_README = """\
# Failures of {controller}

Each `.grid` file is the smallest world found in which the robot fails in one way. The target can
be reached in all of them.

- `known/`: open failures. A search with `--baseline {known}` counts them but does not
  report them as new.
- `fixed/`: failures that no longer occur. `pytest` runs each one and fails if it returns.

`worldgen replay {known}` shows the current state of each failure. After a fix, move its file from
`known/` to `fixed/`.
"""


@dataclass(frozen=True)
class Project:
    """The files that ``worldgen init`` writes.

    Args:
        folder: The project's root; must exist.
        controller: Its name, as for ``worldgen fuzz --controller``.
        motion: Motion model.
        families: Families to test a pull request with; all if empty.
        units: Budget of a pull request's search, in units of work.
        ci: ``github``, ``gitlab`` or ``none``.
    """

    folder: Path
    controller: str
    motion: str = "swept"
    families: tuple[str, ...] = ()
    units: int = 6
    ci: str = "github"

    @property
    def settings(self) -> Path:
        """The project's ``pyproject.toml``."""
        return self.folder / "pyproject.toml"

    @property
    def known(self) -> Path:
        """The folder of open failures."""
        return self.folder / KNOWN

    def check(self, *, force: bool) -> None:
        """Check, before any search, that all files can be written after it.

        Raises:
            OutputError: If a file exists and ``force`` is not set.
            FormatError: If ``pyproject.toml`` is not valid TOML.
            InvalidParameter: If the controller's name cannot be part of a CI file.
        """
        # The controller's name must be safe in the files of a CI service.
        if not self.controller:
            raise InvalidParameter(
                "empty-name",
                "the controller has no name",
                "use one, such as --controller ./file.py:name",
                at_terminal=True,
            )
        if "${{" in self.controller or not self.controller.isprintable():
            raise InvalidParameter(
                "not-for-a-ci-file",
                "controller={controller!r} cannot be written into a CI file, because "
                "${{{{ begins an expression there",
                "choose a name without it",
                controller=self.controller,
            )
        # No existing file may be lost.
        if not self.folder.is_dir():
            raise OutputError(
                "wrong-kind-of-file",
                "{path} is not a folder",
                "use the root of your project",
                path=self.folder,
            )
        check_writable(self.folder / CORPUS, self.folder)
        written = [*self._ci_files(), (self.folder / CORPUS / "README.md", "")]
        taken = [path for path, _ in written if path.exists()]
        if taken and not force:
            raise OutputError(
                "file-exists",
                "{path} already exists",
                "use --force to replace it",
                at_terminal=True,
                path=taken[0],
            )
        if "worldgen" in self._settings().get("tool", {}):
            raise OutputError(
                "already-set-up",
                "{path} already has a [tool.worldgen] table, so this project is already set up",
                "edit that table, or remove it to start over",
                path=self.settings,
            )

    def write(self, *, force: bool) -> list[Path]:
        """Write all files except the failures themselves.

        Returns:
            The paths of the written files, in order.
        """
        # Git does not keep empty folders.
        for folder in (KNOWN, FIXED):
            (self.folder / folder).mkdir(parents=True, exist_ok=True)
            (self.folder / folder / ".gitkeep").touch()
        readme = _CORPUS_README.format(controller=self.controller, known=KNOWN)
        files = [(self.folder / CORPUS / "README.md", readme), *self._ci_files()]
        for path, text in files:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_bytes(path, text.encode(), force=force)
        # Append to the settings instead of rewriting them, to keep comments and order.
        before = self.settings.read_text(encoding="utf-8") if self.settings.exists() else ""
        text = before + ("\n" if before else "") + self._tables()
        write_bytes(self.settings, text.encode(), force=True)
        return [self.settings, *(path for path, _ in files)]

    @property
    def runs_fixed_failures(self) -> bool:
        """True if pytest will run ``fixed/``.

        It will not if the project's settings for pytest are elsewhere.
        """
        pytest: dict[str, Any] = self._settings().get("tool", {}).get("pytest", {})
        return not self._has_other_settings() and (
            not pytest or "worldgen_corpus" in pytest.get("ini_options", pytest)
        )

    def _has_other_settings(self) -> bool:
        """Return True if settings for pytest exist that take precedence over ``pyproject.toml``."""
        if any(
            (self.folder / name).exists()
            for name in ("pytest.toml", ".pytest.toml", "pytest.ini", ".pytest.ini")
        ):
            return True
        for name, table in (("tox.ini", "[pytest]"), ("setup.cfg", "[tool:pytest]")):
            with contextlib.suppress(OSError):
                if table in (self.folder / name).read_text(encoding="utf-8", errors="replace"):
                    return True
        return False

    def _settings(self) -> dict[str, Any]:
        try:
            return tomllib.loads(self.settings.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise FormatError(
                "invalid-toml",
                "is not valid TOML: {reason}",
                "repair it first",
                reason=str(error),
                source=str(self.settings),
            ) from error

    def _tables(self) -> str:
        """Return the tables to add to ``pyproject.toml``."""
        lines = [
            "[tool.worldgen.fuzz]",
            f"controller = {json.dumps(self.controller, ensure_ascii=False)}",
            f'motion = "{self.motion}"',
            f'baseline = ["{KNOWN}"] # open failures, which are not new',
            f"units = {self.units} # the search that each pull request runs",
            f"seed = {SEED}",
        ]
        lines += [f"family = {json.dumps(self.families)}"] if self.families else []
        if self.runs_fixed_failures and "pytest" not in self._settings().get("tool", {}):
            lines += [
                "",
                "[tool.pytest.ini_options]",
                f'worldgen_corpus = ["{FIXED}"] # failures that must stay fixed',
            ]
        return "\n".join(lines) + "\n"

    def _ci_files(self) -> Iterator[tuple[Path, str]]:
        """Yield the CI service's files and their contents."""
        if self.ci == "github":
            yield self.folder / ".github" / "workflows" / "worldgen.yml", self._github()
        elif self.ci == "gitlab":
            yield self.folder / ".gitlab" / "worldgen.yml", self._gitlab()
            main = self.folder / ".gitlab-ci.yml"
            if not main.exists():
                yield main, "include:\n  - local: .gitlab/worldgen.yml\n"

    def _github(self) -> str:
        """Return the workflow; it uses a variable if worldgen was not installed from GitHub."""
        source = origin()
        repository = source.github
        reference = source.commit
        if not repository:
            repository = "${{ vars.WORLDGEN_REPOSITORY }}"
            reference = "${{ vars.WORLDGEN_REF }}"
        families = f"          families: {' '.join(self.families)}\n" if self.families else ""
        return _filled(
            "github.yml",
            REPOSITORY=repository,
            REF=reference,
            INSTALL=" ".join(["pytest", "./.worldgen", *self._own_requirements()]),
            CONTROLLER=_yaml(self.controller),
            MOTION=self.motion,
            FAMILIES=families,
            UNITS=str(self.units),
            SEED=str(SEED),
        )

    def _gitlab(self) -> str:
        source = origin()
        ours = _PLACEHOLDER if source.folder is not None or not source.url else requirement()
        return _filled(
            "gitlab.yml",
            INSTALL=" ".join(["pytest", shlex.quote(ours), *self._own_requirements()]),
            CONTROLLER=shlex.quote(self.controller),
            MOTION=self.motion,
            FAMILIES="".join(f" --family {name}" for name in self.families),
            UNITS=str(self.units),
            SEED=str(SEED),
        )

    @property
    def must_be_told_where_worldgen_is(self) -> str:
        """The settings that a user still has to fill in, because the installation lacks them.

        Empty if there are none.
        """
        source = origin()
        if self.ci == "github" and not source.github:
            return (
                "the repository variables WORLDGEN_REPOSITORY (owner/name) and WORLDGEN_REF (a "
                "commit or tag)"
            )
        if self.ci == "gitlab" and (source.folder is not None or not source.url):
            return "YOUR-HOST and COMMIT in .gitlab/worldgen.yml"
        return ""

    def _own_requirements(self) -> list[str]:
        """Return the arguments with which pip installs the project's own code."""
        own = ["-r requirements.txt"] if (self.folder / "requirements.txt").is_file() else []
        return own + (["-e ."] if "build-system" in self._settings() else [])


def _yaml(text: str) -> str:
    """Return a text as a YAML scalar.

    It stays unquoted if that is safe; otherwise it is put in double quotes, which follow JSON's
    rules.
    """
    plain = set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:+=")
    safe = (
        set(text) <= plain and text[0] in "./abcdefghijklmnopqrstuvwxyz" and not text.endswith(":")
    )
    return text if safe else json.dumps(text)


def _filled(template: str, **values: str) -> str:
    """Return a template with its ``@NAMES@`` filled in."""
    text = (
        importlib.resources.files("fuzz.ci")
        .joinpath("templates", template)
        .read_text(encoding="utf-8")
    )
    for name, value in values.items():
        text = text.replace(f"@{name}@", value)
    return text
