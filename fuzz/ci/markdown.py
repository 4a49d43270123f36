"""A summary in Markdown: a table of failures, and foldable pictures of the smallest worlds."""

from __future__ import annotations

import html
import re

from fuzz.ci.finding import CiFinding, Report

_MOST = 400_000  # characters of pictures; GitHub drops step summaries larger than 1 MiB
_MARKUP = re.compile(r"[\\`*_{}\[\]<>#!|~&@$^]|(?<=:)//|(?<=www)\.")


def markdown(report: Report) -> str:
    """Return a report for people; it ends with an empty line, so that another can follow it."""
    mark = "❌" if report.failing else "❔" if report.no_answer else "✅"
    lines = [f"## {mark} worldgen {report.command}: {report.conclusion}", ""]
    if report.no_answer:
        lines += [
            "The search did not try enough to say whether the robot fails. Next:",
            "",
            f"    {report.remedy}",
            "",
        ]
    if report.facts:
        lines += [
            ", ".join(f"{escaped(name)} {escaped(value)}" for name, value in report.facts.items()),
            "",
        ]
    if report.findings:
        lines += [
            "| | what goes wrong | what happens | controller | world | cause | file |",
            "| --- | --- | --- | --- | --- | --- | --- |",
        ]
        lines += [_row(finding) for finding in report.findings]
        lines.append("")
    # Pictures, until the size limit is reached.
    remaining = _MOST
    for finding in report.findings:
        fold = _fold(finding)
        remaining -= len(fold)
        if remaining < 0:
            lines += ["More pictures would not fit; `worldgen corpus show` draws them.", ""]
            break
        lines += [fold, ""]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Return a text without any markup, for use anywhere but at the beginning of a line."""
    return _MARKUP.sub(
        lambda found: "".join(f"&#{ord(character)};" for character in found[0]), text
    )


def _row(finding: CiFinding) -> str:
    cells = (
        finding.state,
        finding.explanation,
        finding.what,
        finding.who,
        finding.extent,
        finding.group,
        finding.place,
    )
    return f"| {' | '.join(map(escaped, cells))} |"


def _fold(finding: CiFinding) -> str:
    """Return the complete finding in a fold, open if it makes the command exit with code 1."""
    title = html.escape(
        f"{finding.explanation or f'{finding.what}.'} {finding.group}, {finding.state}"
    )
    fold = "<details open>" if finding.fails else "<details>"
    text = html.escape(finding.text)
    return f"{fold}<summary>{title}</summary>\n\n<pre>\n{text}\n</pre>\n\n</details>"
