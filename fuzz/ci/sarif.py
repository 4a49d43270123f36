"""SARIF 2.1.0 for GitHub's code scanning: a rule for each cause, a result for each failure.

The title of a rule says what goes wrong; its id is the cause.

Source: OASIS, "Static Analysis Results Interchange Format (SARIF) Version 2.1.0", 2020.
"""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fuzz.ci.finding import CiFinding, FindingState, Report
from fuzz.ci.markdown import escaped
from fuzz.ci.place import Place, place_of, uri_of
from sim.verdict import MEANINGS, Verdict
from worldgen.support.plain_text import shown

_SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
_ROOT = "%SRCROOT%"
_LONGEST_ID = 200  # characters; GitHub's limit is 255
_MEANINGS: dict[str, str] = {
    **{verdict.value: meaning for verdict, meaning in MEANINGS.items()},
    Verdict.REACHED.value: "The robot arrives, but one of the chosen oracles finds a violation in "
    "its run.",
    FindingState.NOT_CONFIRMED.value: (
        "A stored failure does not replay as stored: the controller has changed, or the file."
    ),
}
_OTHERWISE = "The robot fails, although its target can be reached."


def sarif(report: Report, root: Path) -> bytes:
    """Return a report as SARIF; equal reports in equal repositories give equal bytes.

    A finding that makes the command exit with code 1 is an ``error``; known ones are a ``note``. A
    result is located at the source of the controller, or at the failure's file if the source is
    not in the repository. Its fingerprint consists of controller, motion model and cause, so it
    stays the same if another world of the cause is found.

    Args:
        report: The report.
        root: Root of the repository.
    """
    rules = {_rule_id(finding): _rule(finding) for finding in report.findings}
    ids = list(rules)
    driver = {
        "name": "worldgen",
        "semanticVersion": version("worldgen"),
        "rules": list(rules.values()),
    }
    run: dict[str, Any] = {
        "tool": {"driver": driver},
        "automationDetails": {"id": _category(report)},
        "originalUriBaseIds": {_ROOT: {"description": {"text": "The root of the repository."}}},
        "columnKind": "unicodeCodePoints",
        "results": [
            _result(finding, ids.index(_rule_id(finding)), root) for finding in report.findings
        ],
        "properties": dict(report.facts),
    }
    if report.no_answer:
        run["invocations"] = [_no_answer(report)]
    log = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return (json.dumps(log, indent=1) + "\n").encode()


def _no_answer(report: Report) -> dict[str, Any]:
    """Return the invocation of a campaign without an answer, with a notification that says so."""
    notification = {
        "descriptor": {"id": "no-answer"},
        "level": "note" if report.is_accepted else "error",
        "message": {"text": _message(f"{report.conclusion}. Next: {report.remedy}")},
    }
    return {"executionSuccessful": report.is_accepted, "toolExecutionNotifications": [notification]}


def _category(report: Report) -> str:
    """Return a category for each controller and motion model.

    Uploads with different categories do not close each other's alerts.
    """
    words = (report.command, report.facts.get("controller"), report.facts.get("motion"))
    return "worldgen/" + "/".join(word.replace("/", "-") for word in words if word) + "/"


def _rule_id(finding: CiFinding) -> str:
    return (
        "not-confirmed"
        if finding.state == FindingState.NOT_CONFIRMED
        else finding.group[:_LONGEST_ID]
    )


def _rule(finding: CiFinding) -> dict[str, Any]:
    name = _rule_id(finding)
    verdict = finding.state if finding.state == FindingState.NOT_CONFIRMED else finding.verdict
    meaning = _MEANINGS.get(verdict, _OTHERWISE)
    sentence = "" if finding.state == FindingState.NOT_CONFIRMED else finding.sentence
    how = "The world's file contains a proof. The result gives the command that replays it."
    return {
        "id": name,
        "name": "".join(word.capitalize() for word in name.split("-")),
        "shortDescription": {"text": _message(sentence or f"{verdict}: {name}.")},
        "fullDescription": {"text": _message(meaning)},
        "help": {
            "text": _message(f"{meaning} {how}"),
            "markdown": f"**{escaped(sentence or name)}**\n\n{meaning}\n\n{how}",
        },
        "defaultConfiguration": {"level": "error"},
        "properties": {
            "tags": ["correctness", "robotics"],
            "problem.severity": "error",
            "precision": "very-high",
        },
    }


def _result(finding: CiFinding, rule: int, root: Path) -> dict[str, Any]:
    cause_digest = hashlib.sha256("\0".join((finding.who, finding.group)).encode()).hexdigest()
    world = Place(uri_of(finding.file, root) or quote(shown(finding.file.name)))
    place = (
        world
        if finding.state == FindingState.NOT_CONFIRMED
        else place_of(finding.failure.record.controller, root) or world
    )
    return {
        "ruleId": _rule_id(finding),
        "ruleIndex": rule,
        "level": "error" if finding.fails else "note",
        "message": {"text": _message(_sentences(finding))},
        "locations": [_location(place)],
        "relatedLocations": [
            {"id": 1, **_location(world), "message": {"text": "The world in which it happens."}}
        ],
        "partialFingerprints": {
            "primaryLocationLineHash": f"{cause_digest[:16]}:1",
            "worldgenCause/v1": cause_digest,
        },
        "properties": {
            "state": finding.state,
            "cause": finding.cause,
            "shrinking": finding.failure.shrinking,
            "seed": str(finding.failure.record.seed),
            "world": finding.world_id,
        },
    }


def _sentences(finding: CiFinding) -> str:
    happened = "" if finding.what in finding.headline else f" Verdict: {finding.what}"
    return f"{finding.headline}{happened}. World of {finding.size}: {finding.replay}"


def _location(place: Place) -> dict[str, Any]:
    artifact = {"uri": place.uri, "uriBaseId": _ROOT}
    return {"physicalLocation": {"artifactLocation": artifact, "region": {"startLine": place.line}}}


def _message(text: str) -> str:
    """Return a text without placeholders and links."""
    return text.replace("{", "{{").replace("}", "}}").replace("](", "] (")
