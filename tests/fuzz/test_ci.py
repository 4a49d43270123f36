"""Reports for CI: how JUnit, SARIF and a step's summary describe failures, whatever names they
contain.
"""

import itertools
import json
import shutil
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest

from fuzz.ci import CiFinding, FindingState, Report, place_of, repository
from fuzz.ci.junit import junit
from fuzz.ci.markdown import markdown
from fuzz.ci.sarif import sarif
from fuzz.failure import Failure
from tests.helpers.ci_reports import read_junit, read_markdown, read_sarif
from tests.helpers.command_line import worldgen
from tests.helpers.turned_worlds import turned
from worldgen import read_world, write_world

FAULTS = Path(__file__).parents[2] / "corpora" / "thesis-faults"
LOOP, TUNNEL = FAULTS / "thesis-1-loop-104.grid", FAULTS / "thesis-1-back-off.grid"
GOLDEN = Path(__file__).parent / "golden"
HOSTILE = "\x1b[2J\0\ufffe]]><b>|`@you` {0} [x](http://evil) ##\r\n\udcff"


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A repository with two failures of thesis-1."""
    monkeypatch.delenv("GITHUB_WORKSPACE", raising=False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / ".git").mkdir()
    (tmp_path / "failures").mkdir()
    for path in (LOOP, TUNNEL):
        shutil.copy(path, tmp_path / "failures")
    return tmp_path


def finding(path, state=FindingState.NEW, **changes):
    file = Path("failures") / path.name
    return replace(CiFinding.of(Failure.read(path), file, state), **changes)


def driven_by(controller, state=FindingState.NEW):
    found = finding(LOOP, state)
    record = replace(found.failure.record, controller=controller)
    return replace(found, failure=replace(found.failure, record=record))


def report(*findings, command="fuzz"):
    return Report(command, findings, {"controller": "thesis-1", "motion": "stepped", "seed": "1"})


TWO = report(finding(LOOP), finding(TUNNEL, FindingState.KNOWN))


def test_junit_fails_what_is_new_and_skips_what_is_known():
    new, known = read_junit(junit(TWO)).findall("testcase")
    assert new.find("failure").attrib["message"].startswith("thesis-1 under stepped: It drives")
    assert "\nloop forever" in new.find("failure").text
    assert (
        "\nS start  G target" in new.find("failure").text
        and "worldgen replay failures/" in new.find("failure").text
    )
    assert known.find("failure") is None and known.find("skipped") is not None


def test_junit_says_which_world_and_seed():
    properties = {
        one.attrib["name"]: one.attrib["value"]
        for one in read_junit(junit(TWO))[1].iter("property")
    }
    assert (
        properties["seed"] == str(read_world(LOOP).failure.seed) and len(properties["world"]) == 64
    )


def test_a_campaign_that_finds_nothing_is_one_test_that_passes():
    [case] = read_junit(junit(report())).findall("testcase")
    assert len(case) == 0 and read_sarif(sarif(report(), Path.cwd()))["results"] == []


def test_sarif_is_as_it_was(project):
    new = finding(LOOP, file=project / "a b.grid", what="loop forever {}")
    known = finding(TUNNEL, FindingState.KNOWN, file=project / "failures" / "tunnel.grid")
    text = sarif(report(new, known), project).decode().replace(version("worldgen"), "VERSION")
    assert text == (GOLDEN / "two.sarif").read_text(encoding="utf-8")


def test_sarif_has_a_rule_for_each_cause_and_notes_what_is_known(project):
    run = read_sarif(sarif(report(*TWO.findings, *TWO.findings), project))
    assert len(run["tool"]["driver"]["rules"]) == 2 and len(run["results"]) == 4
    assert [result["level"] for result in run["results"]] == ["error", "note"] * 2


def test_sarif_says_what_goes_wrong_before_it_names_the_cause(project):
    run = read_sarif(sarif(report(finding(LOOP)), project))
    (rule,) = run["tool"]["driver"]["rules"]
    sentence = "It drives from wall to wall on a path that repeats."
    assert rule["shortDescription"]["text"] == sentence
    message = run["results"][0]["message"]["text"]
    assert message.startswith(f"thesis-1 under stepped: {sentence} Verdict: loop forever")


def test_a_fingerprint_is_the_cause_and_not_the_world(project):
    loop = Failure.read(LOOP)
    there = CiFinding.of(
        replace(loop, world=turned(loop.world)), project / "elsewhere.grid", FindingState.NEW
    )
    here, same, other = read_sarif(sarif(report(finding(LOOP), there, finding(TUNNEL)), project))[
        "results"
    ]
    assert (
        here["partialFingerprints"] == same["partialFingerprints"] != other["partialFingerprints"]
    )


def test_no_place_of_this_machine_is_in_a_report(project):
    outside = report(finding(LOOP, file=FAULTS / "a b.grid"))
    run = read_sarif(sarif(outside, project))
    assert (
        run["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
        == "a%20b.grid"
    )


SOURCE = '"""Mine."""\nimport os\n\n\n@print\nclass Robot:\n    pass\n\n\nother: object = Robot\n'


@pytest.mark.parametrize(
    ("controller", "uri", "line"),
    [
        ("./src/mine.py:Robot", "src/mine.py", 6),
        ("./src/mine.py:other", "src/mine.py", 10),
        ("./src/mine.py:absent", "src/mine.py", 1),
        ("mine:Robot", "src/mine.py", 6),
        ("cmd:python3 src/mine.py --fast", "src/mine.py", 1),
        ("cmd+motion=endpoint:./src/mine.py", "src/mine.py", 1),
    ],
)
def test_a_failure_stands_at_its_controllers_source(controller, uri, line, project, monkeypatch):
    (project / "src").mkdir()
    (project / "src/mine.py").write_text(SOURCE)
    monkeypatch.syspath_prepend(project / "src")
    result = read_sarif(sarif(report(driven_by(controller)), project))["results"][0]
    place = result["locations"][0]["physicalLocation"]
    assert (place["artifactLocation"]["uri"], place["region"]["startLine"]) == (uri, line)


def test_a_file_that_does_not_replay_stands_at_itself(project):
    (project / "mine.py").write_text(SOURCE)
    stale = driven_by("./mine.py:Robot", FindingState.NOT_CONFIRMED)
    [result] = read_sarif(sarif(report(stale), project))["results"]
    uri = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == f"failures/{LOOP.name}"


@pytest.mark.parametrize(
    "controller",
    ["thesis-1", "./gone.py:Robot", "no.such:thing", "json:loads", "", "cmd:false", "cmd:'"],
)
def test_a_controller_from_elsewhere_has_no_place(controller, project):
    assert place_of(controller, project) is None


def test_a_repository_is_where_git_or_github_says(project, monkeypatch):
    (project / "deep/er").mkdir(parents=True)
    assert repository(project / "deep/er") == project.resolve()
    monkeypatch.setenv("GITHUB_WORKSPACE", str(project / "deep"))
    assert (
        repository(project / "deep/er") == (project / "deep").resolve()
        and repository() == project.resolve()
    )


def test_words_of_strangers_break_no_report(project):
    world = read_world(LOOP)
    record = replace(world.failure, controller=HOSTILE, details={"class": HOSTILE})
    file = Path(HOSTILE.replace("\0", "").replace("/", ":"))
    bad = report(
        *(
            CiFinding.of(Failure(world, record), file, state, HOSTILE)
            for state in (FindingState.NEW, FindingState.NOT_CONFIRMED)
        )
    )
    assert len(read_sarif(sarif(bad, project))["results"]) == 2
    assert "\x1b" not in junit(bad).decode() and "\0" not in junit(bad).decode()
    [suite] = [read_junit(junit(replace(bad, findings=bad.findings[:1])))]
    assert r"\x1b[2J" in suite.find("testcase/failure").text
    rows, folds = read_markdown(markdown(bad))
    assert (
        len(rows) == len(folds) == 2
        and "@" not in "".join(map("".join, rows))
        and "`" not in rows[0][1]
    )


def test_a_summary_has_a_row_and_a_picture_for_each_failure():
    rows, folds = read_markdown(markdown(TWO))
    assert [row[0] for row in rows] == ["new", "known"]
    assert rows[0][1] == "It drives from wall to wall on a path that repeats."
    assert rows[0][5] == "returns-to-a-wall"
    assert "S start  G target" in folds[0] and "1 new failure, 1 known" in markdown(TWO)


def test_the_title_of_what_has_no_explanation_ends_its_sentence():
    text = markdown(report(finding(LOOP, FindingState.NOT_CONFIRMED, what="not found")))
    assert "<summary>not found. returns" in text


def test_a_summary_that_grows_too_long_says_what_it_leaves_out():
    text = markdown(report(*[finding(LOOP, picture="#" * 19_000)] * 40))
    assert len(text) < 500_000 and "More pictures would not fit" in text


def test_replay_writes_all_three_and_adds_to_the_summary(project):
    outputs = ("--junit", "j.xml", "--sarif", "s.sarif", "--summary", "sum.md")
    assert [
        worldgen("replay", "failures", *outputs, *more).code for more in ((), ("--force",))
    ] == [0, 0]
    assert read_junit(Path("j.xml").read_bytes()).attrib["failures"] == "0"
    assert [one["level"] for one in read_sarif(Path("s.sarif").read_bytes())["results"]] == [
        "note",
        "note",
    ]
    assert Path("sum.md").read_text().count("worldgen replay: 2 of 2 confirmed") == 2


def test_a_file_that_does_not_replay_is_a_failure_of_its_own(project):
    result = worldgen(
        "replay", "failures", "--controller", "thesis-2", "--junit", "j.xml", "--sarif", "s.sarif"
    )
    [first, _] = read_sarif(Path("s.sarif").read_bytes())["results"]
    assert result.code == 1 and first["ruleId"] == "not-confirmed" and first["level"] == "error"
    assert (
        "--controller thesis-2"
        in read_junit(Path("j.xml").read_bytes()).find("testcase/failure").text
    )


def test_a_controller_that_is_not_here_is_reported_without_its_way(project):
    world = read_world(LOOP)
    write_world(
        replace(world, failure=replace(world.failure, controller="./gone.py:Robot")),
        project / "gone.grid",
    )
    assert worldgen("replay", "gone.grid", "--junit", "j.xml").code == 1
    assert (
        "S start  G target\n"
        in read_junit(Path("j.xml").read_bytes()).find("testcase/failure").text
    )


@pytest.mark.gate
def test_a_campaign_reports_the_worst_cause_first_and_its_example_with_what_it_depends_on(project):
    options = ("--units", 1, "--examples", 40, "--seed", 1, "--no-shrink", "--out", "out")
    found = worldgen("fuzz", "--controller", "vfh", *options, "--junit", "j.xml", "--json")
    cases = read_junit(Path("j.xml").read_bytes()).findall("testcase")
    facts = [
        {one.attrib["name"]: one.attrib["value"] for one in case.iter("property")} for case in cases
    ]
    groups = [cause for cause, _ in itertools.groupby(one["cause"] for one in facts)]
    assert groups == [one["cause"] for one in json.loads(found.out)["causes"]]
    assert len(groups) > 1 and len(facts) > len(groups)
    assert "arrives" in facts[0]["why"]
    assert " It arrives" in cases[0].find("failure").attrib["message"]


def test_a_report_that_is_there_is_refused_before_the_work(project):
    Path("j.xml").touch()
    result = worldgen(
        "fuzz", "--controller", "thesis-1", "--budget", "1h", "--out", "out", "--junit", "j.xml"
    )
    assert result.code == 2 and result.error_code == "file-exists" and not Path("out").exists()


@pytest.mark.parametrize(
    ("one", "other"), [("--junit", "--sarif"), ("--sarif", "--report"), ("--junit", "--summary")]
)
def test_two_reports_in_one_file_are_refused_before_the_work(one, other, project):
    result = worldgen(
        "fuzz", "--controller", "thesis-1", "--budget", "1h", "--out", "out", one, "x", other, "./x"
    )
    assert (result.code, Path("out").exists()) == (2, False)
    assert result.error_code == "same-output-twice"


@pytest.mark.gate
def test_fuzz_writes_what_it_found_also_into_the_folder_that_it_makes(project):
    options = (
        "--motion",
        "stepped",
        "--units",
        1,
        "--examples",
        40,
        "--seed",
        1,
        "--workers",
        1,
        "--out",
        "out",
    )
    result = worldgen(
        "fuzz",
        "--controller",
        "thesis-1",
        *options,
        "--json",
        "--sarif",
        "out/s.sarif",
        "--summary",
        "sum.md",
    )
    found = json.loads(result.out)["failures"]
    run = read_sarif(Path("out/s.sarif").read_bytes())
    assert [one["ruleId"] for one in run["results"]] == [one["cause"] for one in found] != []
    assert run["properties"]["seed"] == "1" and len(
        read_markdown(Path("sum.md").read_text())[0]
    ) == len(found)
