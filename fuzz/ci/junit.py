"""JUnit XML: a test case for each failure, or for each file that was replayed."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fuzz.ci.finding import CiFinding, FindingState, Report
from worldgen.support.plain_text import shown

_SKIPPED = {
    FindingState.KNOWN: "known: the baseline has this cause",
    FindingState.HAZARD: "hazard: none of the controller's senses detects what burned the robot",
}


def junit(report: Report) -> bytes:
    """Return a report as JUnit XML; equal reports give equal bytes.

    A finding that makes the command exit with code 1 is a failure. Known failures and hazards are
    skipped, and confirmed files pass. A campaign that finds nothing new gets one additional test
    case that passes, because a report without any would look as if nothing had run. If it has no
    answer, that test case is an error; it is skipped if the user accepts that.
    """
    suites = Element("testsuites", name="worldgen")
    suite = SubElement(suites, "testsuite", name=f"worldgen {report.command}")
    _properties(suite, report.facts)
    for finding in report.findings:
        _case(suite, report.command, finding)
    if report.command == "fuzz" and not report.failing:
        _outcome(suite, report)
    # CI services show these totals, so they must agree with the cases.
    counts = {
        "tests": len(suite.findall("testcase")),
        "failures": report.failing,
        "errors": len(suite.findall("testcase/error")),
        "skipped": len(suite.findall("testcase/skipped")),
    }
    for element in (suites, suite):
        element.attrib |= {name: str(count) for name, count in counts.items()}
    indent(suites, " ")
    text: bytes = tostring(suites, "utf-8", xml_declaration=True)
    return text + b"\n"


def _outcome(suite: Element, report: Report) -> None:
    """Add the test case of a campaign that found nothing new."""
    name = "no answer" if report.no_answer else report.conclusion
    case = SubElement(suite, "testcase", classname="worldgen.fuzz", name=name)
    if not report.no_answer:
        return
    if report.is_accepted:
        SubElement(case, "skipped", message=report.conclusion)
        return
    error = SubElement(case, "error", type="no-answer", message=report.conclusion)
    error.text = f"{report.conclusion}\nnext: {report.remedy}"


def _case(suite: Element, command: str, finding: CiFinding) -> None:
    name = finding.place if command == "replay" else f"{finding.who}: {shown(finding.file.stem)}"
    case = SubElement(
        suite, "testcase", classname=f"worldgen.{command}", name=name, file=finding.place
    )
    about = {
        "group": finding.group,
        "cause": finding.cause,
        "why": finding.why,
        "shrinking": finding.failure.shrinking,
        "seed": finding.failure.record.seed,
        "world": finding.world_id,
        "replay": finding.replay,
    }
    _properties(case, {name: str(value) for name, value in about.items() if value != ""})
    if finding.fails:
        SubElement(
            case, "failure", type=finding.verdict, message=finding.headline
        ).text = finding.text
    else:
        if finding.state in _SKIPPED:
            SubElement(case, "skipped", message=_SKIPPED[finding.state])
        SubElement(case, "system-out").text = finding.text


def _properties(parent: Element, values: Mapping[str, str]) -> None:
    if values:
        properties = SubElement(parent, "properties")
        for name, value in values.items():
            SubElement(properties, "property", name=name, value=value)
