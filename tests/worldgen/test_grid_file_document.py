"""docs/reference/grid-format.md agrees with the code."""

import re
from pathlib import Path

import pytest

from worldgen.domain import MAX_ROBOTS
from worldgen.files.grid import dumps, loads, schema

DOCUMENT = (Path(__file__).parents[2] / "docs" / "reference" / "grid-format.md").read_text(
    encoding="utf-8"
)
EXAMPLES = re.findall(r"```grid\n(.*?)```", DOCUMENT, re.DOTALL)
ERRORS = re.findall(r"```text\n(.*?)```", DOCUMENT, re.DOTALL)[0].splitlines()
LIMITS = {
    "MAX_SIDE": 20_000,
    "MAX_ROBOTS": MAX_ROBOTS,
    "MAX_HEADER_BYTES": schema.MAX_HEADER_BYTES,
    "MAX_FILE_BYTES": schema.MAX_FILE_BYTES,
    "EXPANSION_FLOOR": schema.EXPANSION_FLOOR,
    "EXPANSION_RATIO": schema.EXPANSION_RATIO,
    "MAX_DEPTH": schema.MAX_DEPTH,
    "MAX_INTEGER_BITS": schema.MAX_INTEGER_BITS,
    "MAX_WORD": schema.MAX_WORD,
    "MAX_DIGITS": schema.MAX_DIGITS,
}
WORDS = [
    *schema.HEADER_KEYS,
    *(key for keys in schema.TABLE_KEYS.values() for key in keys),
    *schema.ROBOT_KEYS,
    *(key for keys in schema.TABLES_TABLE_KEYS.values() for key in keys),
    *(f"[{table}]" for table in schema.TABLE_KEYS),
    *(f"%{section}" for section in schema.SECTIONS),
    *schema.STATES,
    *(section.form for section in schema.LINE_SECTIONS.values()),
    *(section.form for section in (schema.ROBOTS_WITNESS, schema.HEADING_WITNESS, schema.BODY_CUT)),
    *(schema.SOLID, schema.FREE, schema.START, schema.TARGET, schema.MAGIC, schema.TABLES_MAGIC),
]


def test_the_document_has_four_examples():
    assert len(EXAMPLES) == 4


@pytest.mark.parametrize("text", EXAMPLES, ids=["complete", "drawn", "fleet", "body"])
def test_an_example_is_a_world_that_survives_writing(text):
    world = loads(text.encode())
    assert loads(dumps(world)) == world


def test_the_complete_example_shows_every_key_and_all_but_one_section():
    missing = [
        word for word in (*schema.HEADER_KEYS, *schema.TABLE_KEYS) if word not in EXAMPLES[0]
    ]
    missing += [
        key
        for keys in schema.TABLE_KEYS.values()
        for key in keys
        if f"\n{key} = " not in EXAMPLES[0]
    ]
    missing += [name for name in schema.SECTIONS if f"\n%{name}\n" not in EXAMPLES[0]]
    assert missing == ["cut"]


@pytest.mark.parametrize("word", WORDS)
def test_the_document_names_every_word_of_the_format(word):
    assert f"`{word}`" in DOCUMENT


@pytest.mark.parametrize("name", LIMITS)
def test_the_document_names_every_limit(name):
    assert re.search(rf"\b{LIMITS[name]}\b", DOCUMENT)


def test_no_limit_of_the_code_is_left_out_above():
    assert {name for name in vars(schema) if name.startswith(("MAX_", "EXPANSION_"))} <= set(LIMITS)


def test_the_form_of_a_line_fits_its_example():
    for section in (
        *schema.LINE_SECTIONS.values(),
        schema.ROBOTS_WITNESS,
        schema.HEADING_WITNESS,
        schema.BODY_CUT,
    ):
        words = section.example.encode().split(b" ")
        assert all(re.fullmatch(f.pattern, w) for f, w in zip(section.fields, words, strict=True))


def test_the_errors_that_the_document_shows_are_real():
    spoilt = EXAMPLES[1].replace("cell_size = 0.1", "cell_size = -0.1")
    uneven = EXAMPLES[0].replace("#.###.#", "#.###.")
    shown = []
    for text in (spoilt, uneven):
        with pytest.raises(ValueError, match=r"w\.grid") as caught:
            loads(text.encode(), "w.grid")
        shown.append(str(caught.value))
    assert shown == ERRORS
