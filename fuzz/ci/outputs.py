"""The report files that a user can request from a command."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from worldgen.errors import OutputError
from worldgen.files.whole import check_output, refused_writes, write_bytes
from worldgen.support.paths import real_path

if TYPE_CHECKING:
    from fuzz.ci.finding import Report


@dataclass(frozen=True)
class Outputs:
    """Destinations of reports; each is optional.

    Args:
        junit: A file for JUnit XML.
        sarif: A file for SARIF.
        summary: A file to which a summary in Markdown is appended.
        force: Overwrite the first two if they exist.
    """

    junit: Path | None = None
    sarif: Path | None = None
    summary: Path | None = None
    force: bool = False

    def __bool__(self) -> bool:
        return any((self.junit, self.sarif, self.summary))

    def check(self, page: Path | None = None, *, made: Path | None = None) -> None:
        """Check before the work starts that the reports can be written after it.

        Args:
            page: The HTML page that will be written as well.
            made: A folder that the work will create if missing; files in it can be written.

        Raises:
            OutputError: If a file exists, cannot be created, or is named for two reports.
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
            # The campaign creates its own folder, so no reports in it can exist yet.
            if made is None or made.exists() or real_path(path).parent != real_path(made):
                check_output(path, self.force or option == "--summary")
            other = named.setdefault(real_path(path), option)
            if other != option:
                raise OutputError(
                    "same-output-twice",
                    "{path} is named for {other} and for {option}",
                    "give each report its own file",
                    path=path,
                    other=other,
                    option=option,
                )

    def write(self, report: Report) -> None:
        """Write the requested reports.

        Raises:
            OutputError: If a file cannot be written.
        """
        # Each report loads only what it needs; most commands write none.
        if self.junit is not None:
            from fuzz.ci.junit import junit

            write_bytes(self.junit, junit(report), force=self.force)
        if self.sarif is not None:
            from fuzz.ci.place import repository
            from fuzz.ci.sarif import sarif

            write_bytes(self.sarif, sarif(report, repository()), force=self.force)
        if self.summary is not None:
            from fuzz.ci.markdown import markdown

            with (
                refused_writes(self.summary),
                self.summary.open("a", encoding="utf-8", newline="\n") as stream,
            ):
                stream.write(markdown(report))


NO_OUTPUTS = Outputs()
