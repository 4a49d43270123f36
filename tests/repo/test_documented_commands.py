"""Every command that README.md and docs/ show works, and prints what the page shows."""

import pytest

from tests.repo.documented_commands import (
    PAGES,
    ROOT,
    Command,
    Done,
    faults,
    matches,
    parse_page,
    read_page,
    run_page,
    updated,
)

TIERS: dict[
    str, tuple[()]
] = {}  # pages whose commands are quick enough for the default tier; most take minutes
PAGE = """\
# A page

```console
$ worldgen trap --size 20 --seed 4 --out w.grid
w.grid: trap 20 x 20 cells, witness ... s, seed 4
$ worldgen show \\
    missing.grid
hello
...
$ cat mine.py  # is there
```

```python
# mine.py: a file of the page
pass
```
"""


def page(text=PAGE):
    return parse_page(text, ROOT / "page.md")


@pytest.mark.usefixtures("drawn_seeds")
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.name, marks=TIERS.get(path.name, pytest.mark.nightly))
        for path in PAGES
        if any(block.not_run is None for block in read_page(path).blocks)
    ],
)
def test_the_commands_of_a_page_print_what_it_shows(path, tmp_path):
    assert "\n\n".join(faults(path, tmp_path)) == ""


def test_commands_run_in_a_folder_of_their_own_with_the_files_of_the_page(tmp_path):
    made, shown, cat = run_page(page(), tmp_path)
    assert (made.code, made.fault) == (0, None) and (tmp_path / "w.grid").exists()
    assert cat.printed == ["# mine.py: a file of the page", "pass"] and cat.fault is None
    assert shown.command.text == "worldgen show missing.grid" and shown.code == 2


def test_an_output_other_than_the_one_shown_is_a_fault(tmp_path):
    shown = list(run_page(page(), tmp_path))[1]
    assert shown.fault.startswith(
        "$ worldgen show missing.grid\n--- the page shows\nhello\n...\n--- it prints\n"
    )


def test_a_command_that_cannot_do_its_work_is_a_fault_where_the_page_shows_nothing(tmp_path):
    (done,) = run_page(page("```console\n$ worldgen show missing.grid\n```\n"), tmp_path)
    assert done.fault.startswith("worldgen show missing.grid: exit code 2")


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        pytest.param(["a", "b"], ["a", "b"], True, id="equal"),
        pytest.param(["a"], ["a", "b"], False, id="a line more"),
        pytest.param(["a", "..."], ["a", "b", "c"], True, id="lines left out"),
        pytest.param(["a", "...", "c"], ["a", "c"], True, id="no line left out"),
        pytest.param(["a ... d"], ["a b c d"], True, id="words left out"),
        pytest.param(["a ... d"], ["a b", "c d"], False, id="words left out end with the line"),
        pytest.param(["#....#"], ["#.#..#"], False, id="another map"),
        pytest.param(
            ["# ... # ... #"] * 40 + ["a"],
            ["# # # # # #"] * 40 + ["b"],
            False,
            id="many lines left open",
        ),
        pytest.param(["9 worlds in 1.5 s"], ["9 worlds in 27 s"], True, id="another time"),
        pytest.param(["9 worlds in 1.5 s"], ["8 worlds in 1.5 s"], False, id="another number"),
    ],
)
def test_three_dots_and_durations_stand_for_anything(shown, printed, same):
    assert matches(shown, printed) is same


def test_an_update_writes_what_is_printed_and_keeps_what_is_left_out():
    first, second, _ = page().blocks[0].commands
    text = updated(
        PAGE, [Done(first, 0, ["w.grid: other", "and more"]), Done(second, 0, ["bye", "x", "y"])]
    )
    assert (
        "\nw.grid: other\nand more\n$ worldgen show \\\n    missing.grid\nbye\n...\n$ cat" in text
    )


def test_an_update_shows_no_message_of_a_command_that_could_not_do_its_work():
    first, *_ = page().blocks[0].commands
    assert updated(PAGE, [Done(first, 2, ["worldgen: w.grid is there already"])]) == PAGE


def test_an_update_leaves_alone_what_differs_only_in_how_long_it_took():
    command = Command("worldgen fuzz", 1, 2, ["found in 3 s"])
    assert updated(
        "$ worldgen fuzz\nfound in 3 s\n", [Done(command, 1, ["found in 4 s"])]
    ).endswith("found in 3 s\n")


def test_comments_leave_a_block_out_or_run_what_the_reader_does_not_see(tmp_path):
    text = (
        "<!-- not run: it takes an hour -->\n```console\n$ sleep 3600\n```\n"
        "<!-- needs: no-such-program -->\n```console\n$ no-such-program\n```\n"
        "<!-- first: echo hidden > file -->\n```console\n$ cat file\nhidden\n```\n"
    )
    assert [done.command.text for done in run_page(page(text), tmp_path)] == [
        "echo hidden > file",
        "cat file",
    ]
    assert page(text).blocks[0].not_run == "it takes an hour"


def test_only_a_search_has_units_instead_of_a_budget(tmp_path):
    text = (
        "```console\n$ worldgen find --budget 9h\n$ worldgen shrink missing.grid --budget 9h\n```\n"
    )
    find, shrink = run_page(page(text), tmp_path)
    assert (
        "--outcome" in "\n".join(find.printed)
        and "missing.grid: there is no such file" in shrink.printed[0]
    )


def test_a_page_that_shows_what_a_budget_of_seconds_found_is_refused():
    with pytest.raises(ValueError, match="give it --units"):
        page("```console\n$ worldgen fuzz --controller bug2 --budget 30s\nno failure\n```\n")
