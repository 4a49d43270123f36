"""Independent readers of the reports for CI.

Each checks a report by the rules of its format and returns it.
"""

import json
import re
from urllib.parse import urlparse
from xml.etree import ElementTree

IN_A_CASE = ("properties", "skipped", "failure", "error", "system-out", "system-err")


def read_junit(data):
    """JUnit's XML as an element.

    Checks that children are in the schema's order and that counts are right.
    """
    suites = ElementTree.fromstring(data)
    assert suites.tag == "testsuites" and [suite.tag for suite in suites] == ["testsuite"]
    suite = suites[0]
    cases = suite.findall("testcase")
    assert [child.tag for child in suite if child.tag != "testcase"] in (
        [],
        ["properties"],
    ) and cases
    assert len({case.attrib["name"] for case in cases}) == len(cases) and all(
        case.attrib["classname"] for case in cases
    )
    for case in cases:
        places = [IN_A_CASE.index(child.tag) for child in case]
        assert places == sorted(set(places))
    for element in (suites, suite):
        counts = [int(element.attrib[name]) for name in ("tests", "failures", "skipped", "errors")]
        assert counts == [
            len(cases),
            len(suite.findall("*/failure")),
            len(suite.findall("*/skipped")),
            len(suite.findall("*/error")),
        ]
    return suite


def read_sarif(data):
    """Return the only run of a SARIF log that GitHub would accept.

    Checks that rules exist and that places are in the repository.
    """
    log = json.loads(data)
    assert log["version"] == "2.1.0" and len(log["runs"]) == 1
    run = log["runs"][0]
    rules = run["tool"]["driver"]["rules"]
    assert len({rule["id"] for rule in rules}) == len(rules)
    assert all(rule["help"]["text"] and rule["shortDescription"]["text"] for rule in rules)
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"] and result["level"] in (
            "error",
            "warning",
            "note",
        )
        assert result["message"]["text"] and "](" not in result["message"]["text"]
        assert re.fullmatch(
            "[0-9a-f]{16}:1", result["partialFingerprints"]["primaryLocationLineHash"]
        )
        for place in (*result["locations"], *result["relatedLocations"]):
            artifact, region = (
                place["physicalLocation"][name] for name in ("artifactLocation", "region")
            )
            assert artifact["uriBaseId"] == "%SRCROOT%" and region["startLine"] >= 1
            uri = urlparse(artifact["uri"])
            assert (
                not uri.scheme
                and not uri.netloc
                and uri.path
                and not uri.path.startswith(("/", ".."))
            )
    return run


def read_markdown(text):
    """Return the rows of a summary's table, each a list of cells, and its collapsed sections.

    Markup in names would break either.
    """
    table = re.sub(r"<pre>[^<>]*</pre>", "", text)
    rows = [line.strip("|").split("|") for line in table.splitlines() if line.startswith("|")]
    assert len({len(row) for row in rows}) <= 1
    folds = re.findall(
        r"<details(?: open)?><summary>[^<>]*</summary>\n\n<pre>\n([^<>]*)\n</pre>\n\n</details>",
        text,
    )
    assert len(folds) == text.count("<") // 6  # no other tag
    return [[cell.strip() for cell in row] for row in rows[2:]], folds
