"""Trees that remember what a reader takes, and what is said about the rest."""

import pytest

from tests.helpers.raising import raises
from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, account_for, accounting, parse_json, report_unread
from worldgen.interop.readers.xml_tree import read_xml
from worldgen.interop.readers.yaml_table import read_yaml


def test_what_nobody_took_is_unread():
    with accounting() as account:
        document = parse_json(
            '{"a": 1, "b": {"c": 2, "d": 3}, "e": [], "f": null, "walls": [1, 2]}'
        )
        assert document["a"] == 1 and document["b"].get("c") == 2
    assert account.total(()) == ("1 value of d in b", "2 walls")


def test_an_item_that_nobody_touched_is_one_element():
    with accounting() as account:
        items = parse_json('{"items": [{"x": 1, "y": 2}, {"x": 3, "y": 4}, {}]}')["items"]
        assert items[0]["x"] == 1
    assert account.total(()) == ("1 item", "1 value of y in items")


def test_peeking_and_asking_for_a_name_do_not_take():
    part = NamedParts([("a", 1)])
    assert "a" in part and part.peek("a") == 1 and list(part) == ["a"]
    assert list(part.untaken()) == ["a"]
    assert part["a"] == 1 and list(part.untaken()) == []


@pytest.mark.parametrize("harmless", [{"c"}, {"b/c"}, {"b"}])
def test_harmless_names_do_not_count(harmless):
    with accounting() as account:
        assert parse_json('{"b": {"c": 2}}')["b"]
    assert account.total(()) == ("1 value of c in b",)
    assert account.total(harmless) == ()


def test_an_element_of_xml_is_taken_one_by_one():
    with accounting() as account:
        root = read_xml(b"<a xmlns:n='n' k='1' m='2'><b>x</b><b/><c>text<d/></c></a>")
        assert root.first("b").text == "x" and root.attributes.get("k") == "1"
        assert root.first("c", "d").name == "d"
    expected = ("1 attribute m of <a>", "1 element <b> in <a>", "1 text in <c>")
    assert account.total(()) == expected


def test_a_table_of_yaml_counts_its_keys():
    with accounting() as account:
        table = read_yaml(b"a: 1\nb:\n  - {c: 1, d: 2}\n  - {c: 3}\ne: [1]\n", "a: 1")
        assert table.word("a") == "1" and [one.word("c") for one in table.tables("b")] == ["1", "3"]
    assert account.total(()) == ("1 key d in b", "1 key e")


def test_a_key_that_is_given_twice_is_refused_because_one_value_would_be_lost():
    with raises(FormatError, "twice", name="layers"):
        parse_json('{"layers": [1], "layers": []}')


def test_what_readers_report_is_counted_with_the_rest():
    with accounting() as account:
        report_unread("bodies with holes", 1)
        report_unread("frames after the first", 2)
        report_unread("nothing", 0)
    assert account.total(()) == ("1 body with holes", "2 frames after the first")


def test_readings_do_not_mix():
    with accounting() as outer:
        with accounting() as inner:
            report_unread("walls", 3)
        account_for(NamedParts([("a", 1)]))
    assert (outer.total(()), inner.total(())) == (("1 value of a",), ("3 walls",))


def test_many_kinds_are_counted_together():
    with accounting() as account:
        account_for(NamedParts((f"k{n:03}", 1) for n in range(30)))
    total = account.total(())
    assert len(total) == 21 and total[-1] == "10 other elements"
