"""The files with reports that a user asks a command for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fuzz.ci.finding import Report
from fuzz.ci.junit import junit
from fuzz.ci.markdown import markdown
from fuzz.ci.place import repository
from fuzz.ci.sarif import sarif
from worldgen.errors import OutputError
from worldgen.files.whole import check_output, write_bytes

__all__ = ["NO_OUTPUTS", "Outputs"]


@dataclass(frozen=True)
class Outputs:
    """Where reports go; each may be left out.

    Args:
        junit: A file for JUnit's XML.
        sarif: A file for SARIF.
        summary: A file to whose end a summary in Markdown is added.
        force: Whether the first two may be overwritten.
    """

    junit: Path | None = None
    sarif: Path | None = None
    summary: Path | None = None
    force: bool = False

    def __bool__(self) -> bool:
        return any((self.junit, self.sarif, self.summary))

    def check(self, page: Path | None = None, *, made: Path | None = None) -> None:
        """Refuses before the work what could not be written after it.

        Args:
            page: The HTML page that is to be written as well.
            made: A folder that the work makes if it is not there: what lies in it can be written.

        Raises:
            OutputError: If a file is there, cannot be made, or is named for two reports.
        """
        named: dict[Path, str] = {}
        options = {
            "--junit": self.junit,
            "--sarif": self.sarif,
            "--report": page,
            "--summary": self.summary,
        }
        for option, path in options.items():
            if path is None:
                continue
            if made is None or made.exists() or path.resolve().parent != made.resolve():
                check_output(path, self.force or option == "--summary")
            other = named.setdefault(path.resolve(), option)
            if other != option:
                raise OutputError(
                    "same-output-twice",
                    "{path} is named for {other} and for {option}",
                    "give each a file of its own",
                    path=path,
                    other=other,
                    option=option,
                )

    def write(self, report: Report) -> None:
        """Writes what was asked for.

        Raises:
            OutputError: If a file cannot be written.
        """
        if self.junit is not None:
            write_bytes(self.junit, junit(report), force=self.force)
        if self.sarif is not None:
            write_bytes(self.sarif, sarif(report, repository()), force=self.force)
        if self.summary is not None:
            try:
                with self.summary.open("a", encoding="utf-8", newline="\n") as stream:
                    stream.write(markdown(report))
            except OSError as error:
                raise OutputError(
                    "unwritable",
                    "{path}: cannot be written: {reason}",
                    path=self.summary,
                    reason=error.strerror or str(error),
                ) from error


NO_OUTPUTS = Outputs()
