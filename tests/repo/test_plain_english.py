"""The counter of translated English finds what it should, and the sources stay under its limit."""

import pytest

from tests.repo import plain_english


def _names(tmp_path, monkeypatch, name, text):
    monkeypatch.setattr(plain_english, "ROOT", tmp_path)
    (tmp_path / name).write_text(text, encoding="utf-8")
    return [(mark.line, mark.name) for mark in plain_english.marks_of(tmp_path / name)[1]]


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [
        ("a.py", '"""Turns for ever."""\n', [(1, "for ever")]),
        ("a.py", "x = 1\n# One is no robot.\n", [(2, "is no")]),
        (
            "a.py",
            'x = f"the file {1} lies there beside others"\n',
            [(1, "beside"), (1, "stands in")],
        ),
        ("a.py", 'x = "beside"\n', []),
        ("a.py", "# There is no wall, and it is no longer there.\nx = None\n", []),
        ("a.c", "// It goes on.\nint x;\n", [(1, "goes on")]),
        ("a.md", "One.\n\n```\nlikewise\n```\n\nTwo likewise.\n", [(7, "likewise")]),
    ],
)
def test_marks_are_found_in_prose_with_their_lines(tmp_path, monkeypatch, name, text, found):
    assert sorted(_names(tmp_path, monkeypatch, name, text)) == found


#: Marks per 10,000 words that a folder may have; Hypothesis, NumPy and SciPy have up to 2.2, and
#: some constructions are plain English in context.
LIMIT = 15.0


@pytest.mark.parametrize("folder", [*plain_english.FOLDERS, *plain_english.PAGES])
def test_a_folder_stays_under_the_limit_of_marks(folder):
    counted = [plain_english.marks_of(path) for path in plain_english.readable_files([folder])]
    words = sum(count for count, _ in counted)
    marks = [mark for _, found in counted for mark in found]
    listed = "\n".join(f"{one.path}:{one.line}: {one.name}: {one.sentence}" for one in marks)
    assert 1e4 * len(marks) <= LIMIT * max(words, 1000), listed
