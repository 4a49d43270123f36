"""A summary in Markdown.

A table of classes, and the smallest world of each as a picture in a fold.
"""

from __future__ import annotations

import html
import re

from fuzz.ci.finding import CiFinding, Report

__all__ = ["escaped", "markdown"]

_MOST = 400_000  # characters of folds; GitHub drops a step's summary that is larger than 1 MiB
_MARKUP = re.compile(r"[\\`*_{}\[\]<>#!|~&@$^]|(?<=:)//|(?<=www)\.")


def markdown(report: Report) -> str:
    """A report for people; ends with an empty line, so that another can follow it."""
    mark = "❌" if report.failing else "✅"
    lines = [f"## {mark} worldgen {report.command}: {report.conclusion}", ""]
    if report.facts:
        lines += [
            ", ".join(f"{escaped(name)} {escaped(value)}" for name, value in report.facts.items()),
            "",
        ]
    if report.findings:
        lines += [
            "| | class | controller | what happens | world | file |",
            "| --- | --- | --- | --- | --- | --- |",
        ]
        lines += [_row(finding) for finding in report.findings]
        lines.append("")
    room = _MOST
    for finding in report.findings:
        fold = _fold(finding)
        room -= len(fold)
        if room < 0:
            lines += ["More pictures would not fit; `worldgen corpus show` draws them.", ""]
            break
        lines += [fold, ""]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """A text in which nothing is markup, wherever in a line it stands but at its beginning."""
    return _MARKUP.sub(
        lambda found: "".join(f"&#{ord(character)};" for character in found[0]), text
    )


def _row(finding: CiFinding) -> str:
    cells = (finding.state, finding.kind, finding.who, finding.what, finding.size, finding.place)
    return f"| {' | '.join(map(escaped, cells))} |"


def _fold(finding: CiFinding) -> str:
    """All of a finding; open if it makes the command end with 1."""
    title = html.escape(f"{finding.kind}, {finding.state}")
    fold = "<details open>" if finding.fails else "<details>"
    return f"{fold}<summary>{title}</summary>\n\n<pre>\n{html.escape(finding.text)}\n</pre>\n\n</details>"
