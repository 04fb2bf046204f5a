"""Strict YAML: YAML 1.2's scalars, places of all parts, mistakes in plain words, bounds on size."""

from __future__ import annotations

import math
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orthospec.errors import SpecError
from orthospec.spec.strict_yaml import parse
from orthospec.spec.writing import dump


def data(text: str) -> Any:
    document = parse(text, "f.yaml")
    assert not document.mistakes
    return document.data


def mistakes(text: str) -> list[str]:
    try:
        found = parse(text, "f.yaml").mistakes
    except SpecError as error:
        found = list(error.mistakes)
    return [str(mistake) for mistake in found]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("1E5", 1e5), ("-.5", -0.5), ("3.", 3.0), ("+7", 7), ("010", 10), ("0o10", 8),
        ("0x1f", 31), ("-.inf", -math.inf), ("1e999", math.inf), ("true", True), ("False", False),
        ("~", None), ("", None), ("null", None), ("NO", "NO"), ("yes", "yes"), ("on", "on"), ("=", "="),
        ("12:30:00", "12:30:00"), ("2024-01-01", "2024-01-01"), ("1_000", "1_000"), ("0b1", "0b1"),
        ("310 mm", "310 mm"), ("'1'", "1"), ('"null"', "null"), ("9" * 5000, math.inf),
    ],
)  # fmt: skip
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    read = data(f"key: {text}")["key"]
    assert read == value
    assert type(read) is type(value)


def test_not_a_number_is_read_as_such() -> None:
    assert math.isnan(data("key: .NaN")["key"])


def test_every_part_has_its_place() -> None:
    document = parse("a:\n  b: [1, 22]\nc: x\n", "f.yaml")
    assert document.place(("a",)) == "f.yaml:1:1"
    assert document.place(("a", "b")) == "f.yaml:2:3"
    assert document.place(("a", "b", 1)) == "f.yaml:2:10"
    assert str(document.mistake(("c",), "no")) == "f.yaml:3:4: no"
    assert str(document.mistake(("c", "d", 3), "no")) == "f.yaml:3:1: no"
    assert str(document.mistake(("nowhere",), "no")) == "f.yaml:1:1: no"


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm() -> None:
    assert data("\ufeffa: 1\r\nb:\r\n  - 2\r\n") == {"a": 1, "b": [2]}


def test_an_alias_is_its_anchor_again() -> None:
    assert data("a: &leg [1, 2]\nb: *leg") == {"a": [1, 2], "b": [1, 2]}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "1:1: the file is empty"),
        ("# only a comment\n", "1:1: the file is empty"),
        ("a: 1\nb: 2\na: 3", "3:1: duplicate key 'a', first given at 1:1"),
        ("a: {b: 1, b: 2}", "1:11: duplicate key 'b', first given at 1:5"),
        ("1: a", "1:1: the key 1 is not a name; write it in quotes, '1'"),
        ("true: a", "1:1: the key true is not a name; write it in quotes, 'true'"),
        ("? [a]\n: 1", "1:3: a key must be a name; is a quote missing around { or [?"),
        ("base: &b {x: 1}\nc: {<<: *b}", "2:5: merge keys (<<) are not read; write the keys out"),
        ("a: !!float 1", "1:4: the tag tag:yaml.org,2002:float is not read here; leave it out"),
        ("a: !python/name:os x", "1:4: the tag !python/name:os is not read here; leave it out"),
        ("a: *b", "1:4: nothing above is marked &b"),
        ("a: &a [*a]", "1:8: nothing above is marked &a"),
        ("a: 1\n---\nb: 1", "2:1: a second document starts here; a spec is one document"),
        ("a:\n\tb: 1", "2:1: a tab indents this line; YAML takes spaces only"),
        ("a: b: 1", "1:5: a ':' where none can stand; is the indentation wrong, or a quote missing?"),
        ("a: [1, 2", "1:4: a list in [ ] is not closed, or lacks a comma"),
        ("a: {b: 1", "1:4: a mapping in { } is not closed, or lacks a comma"),
        ("a: 'x", "1:4: a quote is opened and not closed"),
        ("a: {b: 1 c: 2}\nd: 1", "1:11: a mapping in { } is not closed, or lacks a comma"),
        ("a: [1, {2]\nd: 1", "1:10: a mapping in { } is not closed, or lacks a comma"),
        ("a:\n  b: 1\n c: 2", "3:2: the indentation does not fit the lines above, or a ':' is missing"),
        ("a: @x", "1:4: no text starts with @ in YAML; put it in quotes"),
        ('a: "\\z"', "1:5: a '\\' in double quotes has a meaning of its own; use single quotes"),
        ("a: 1\nb: \x07", "2:4: the character U+0007 cannot stand in YAML"),
        ("a: {x: max(b, c), y: 1}", '1:8: an expression with a comma needs quotes here: "max(b, c)"'),
        ("a: [max(b, min(c, d))]", '1:5: an expression with a comma needs quotes here: "max(b, min(c, d))"'),
    ],
)  # fmt: skip
def test_a_mistake_is_told_in_plain_words(text: str, expected: str) -> None:
    assert mistakes(text) == [f"f.yaml:{expected}"]


def test_a_torn_expression_is_put_together_so_that_checking_can_go_on() -> None:
    assert parse("{x: max(b, c), y: 1}", "f.yaml").data == {"x": "max(b, c)", "y": 1}


def test_a_comma_in_block_style_needs_no_quotes() -> None:
    assert data("x: max(b, c)") == {"x": "max(b, c)"}


def test_aliases_of_aliases_are_counted_as_often_as_they_are_used() -> None:
    lines = ["a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"{c}: &{c} [{', '.join([f'*{b}'] * 10)}]" for b, c in zip("abcdefgh", "bcdefghi", strict=True)]
    began = time.perf_counter()
    assert "more than 100000 values" in mistakes("\n".join(lines))[0]
    assert time.perf_counter() - began < 5


@pytest.mark.parametrize("bracket", ["[", "{a: ", "- "])
def test_depth_is_bounded(bracket: str) -> None:
    assert "nested more than 40 deep" in mistakes(bracket * 20_000)[0]


def test_size_is_bounded() -> None:
    assert mistakes("a: " + "x" * 1_000_001) == ["f.yaml: larger than 1000 kB"]


SCALARS = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=12)
CONTENT = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=12,
)


@given(st.dictionaries(st.text(min_size=1, max_size=6), CONTENT, min_size=1, max_size=4))
def test_what_is_dumped_is_read_back(content: dict[str, Any]) -> None:
    assert data(dump(content)) == content


@given(st.text(max_size=80) | st.text("ab:-[]{}&*!|>'\"#,? \n\t1.", max_size=80))
def test_any_text_is_read_or_refused_with_a_place(text: str) -> None:
    assert all(mistake.startswith("f.yaml:") and mistake[7].isdigit() for mistake in mistakes(text))
