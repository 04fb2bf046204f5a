"""Strict YAML with places: what a spec's text says, and at which line and column.

PyYAML parses; the scalars are YAML 1.2's (``1e-3`` is a number, ``NO`` and ``12:30:00`` are strings, ``010``
is 10). Duplicate keys, tags, merge keys and keys that are not strings are mistakes; depth and size are
bounded, aliases counted as often as they are used.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import yaml

from orthospec.errors import Mistake, SpecError
from orthospec.spec.document import Document, Path, Place

LARGEST, LARGEST_RESULT, _DEEPEST = 1_000_000, 100_000_000, 40
"""Characters of a spec, and of a result, where a long sweep is larger than any spec; levels of nesting."""
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class _Node:
    place: Place
    plain: bool = False
    flow: bool = False
    text: str | None = None
    items: tuple[_Node, ...] = ()
    pairs: tuple[tuple[_Node, _Node], ...] | None = None


def parse(text: str, file: str, largest: int = LARGEST, empty: str = "the file is empty") -> Document:
    """The document in a text; raises `SpecError` where it is not YAML, else collects its mistakes.

    ``largest`` bounds the characters, and a tenth of it the values; ``empty`` is said of a text of nothing.
    """
    text = text.removeprefix("\ufeff")
    document = Document(file)
    if len(text) > largest:
        raise SpecError([Mistake(file, 0, 0, f"larger than {largest // 1000} kB")])
    root = _compose(text, file)
    if root is None or (root.plain and not root.text):
        raise SpecError([Mistake(file, 1, 1, empty)])
    document.data = _Reader(document, largest // 10).value(root, ())
    return document


def _compose(text: str, file: str) -> _Node | None:
    try:
        events = yaml.parse(text, Loader=_LOADER)
        return _Composer(events, file).document()
    except yaml.MarkedYAMLError as error:
        raise SpecError([_syntax_mistake(error, text, file)]) from None
    except yaml.reader.ReaderError as error:
        code = error.character if isinstance(error.character, int) else ord(error.character)
        before = text[: max(text.find(chr(code)), 0)]
        place = Place(before.count("\n") + 1, len(before) - before.rfind("\n"))
        raise SpecError([Mistake(file, *place, f"the character U+{code:04X} cannot stand in YAML")]) from None


_TOO_DEEP = f"nested more than {_DEEPEST} deep"
_WORDS = (
    (r"maximum nesting depth", _TOO_DEEP),
    (r"escape character|hexdecimal", r"a '\' in double quotes has a meaning of its own; use single quotes"),
    (r"mapping values", "a ':' where none can stand; is the indentation wrong, or a quote missing?"),
    (r"unexpected end of stream", "a quote is opened and not closed"),
    (r"expected ',' or '\]'", "a list in [ ] is not closed, or lacks a comma"),
    (r"expected ',' or '\}'", "a mapping in { } is not closed, or lacks a comma"),
    (r"expected '-'|block sequence", "this does not line up with the list above"),
    (r"expected key|expected ':'|block", "the indentation does not fit the lines above, or a ':' is missing"),
)


def _syntax_mistake(error: yaml.MarkedYAMLError, text: str, file: str) -> Mistake:
    """PyYAML's complaint in plain words; what is never closed is told where it opens."""
    problem, opened = error.problem_mark, error.context_mark
    place = Place(problem.line + 1, problem.column + 1) if problem else Place(1, 1)
    lines = text.splitlines()
    line = lines[place.line - 1] if place.line <= len(lines) else ""
    words = _plain_words(f"{error.problem or ''} {error.context or ''}", line, place.column)
    if opened and "closed" in words and not any((line[place.column :], *lines[place.line :])):
        place = Place(opened.line + 1, opened.column + 1)
    return Mistake(file, *place, words)


def _plain_words(said: str, line: str, column: int) -> str:
    if "\t" in line[: len(line) - len(line.lstrip())]:
        return "a tab indents this line; YAML takes spaces only"
    if "cannot start any token" in said:
        return f"no text starts with {line[column - 1 : column]} in YAML; put it in quotes"
    return next((words for pattern, words in _WORDS if re.search(pattern, said)), f"not YAML: {said.strip()}")


_Entry: TypeAlias = tuple[_Node, _Node]
"""Key and value."""
_NO_KEY = _Node(Place(0, 0))
"""Stands for the key of a list's item."""


class _Composer:
    """Events to nodes, iterating with a bounded depth; an alias gives its anchor's node again."""

    def __init__(self, events: Iterator[yaml.Event], file: str) -> None:
        self._events = events
        self._file = file
        self._anchors: dict[str, _Node] = {}

    def document(self) -> _Node | None:
        root = None
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                if root is not None:
                    raise self._error(event, "a second document starts here; a spec is one document")
                root = self._node(next(self._events), 0)
        return root

    def _node(self, event: Any, depth: int) -> _Node:
        if depth > _DEEPEST:
            raise self._error(event, _TOO_DEEP)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise self._error(event, f"nothing above is marked &{event.anchor}")
            return self._anchors[event.anchor]
        if event.tag is not None:
            raise self._error(event, f"the tag {event.tag} is not read here; leave it out")
        node = self._untagged(event, depth)
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        return node

    def _untagged(self, event: Any, depth: int) -> _Node:
        place = Place(event.start_mark.line + 1, event.start_mark.column + 1)
        if isinstance(event, yaml.ScalarEvent):
            return _Node(place, plain=not event.style, text=event.value)
        if isinstance(event, yaml.SequenceStartEvent):
            items = tuple(self._until(yaml.SequenceEndEvent, depth))
            return _Node(place, flow=bool(event.flow_style), items=items)
        nodes = list(self._until(yaml.MappingEndEvent, depth))
        pairs = tuple(zip(nodes[::2], nodes[1::2], strict=True))
        return _Node(place, flow=bool(event.flow_style), pairs=pairs)

    def _until(self, end: type[yaml.Event], depth: int) -> Iterator[_Node]:
        for event in self._events:
            if isinstance(event, end):
                return
            yield self._node(event, depth + 1)

    def _error(self, event: Any, message: str) -> SpecError:
        mark = event.start_mark
        return SpecError([Mistake(self._file, mark.line + 1, mark.column + 1, message)])


class _Reader:
    """Nodes to plain Python, noting places and mistakes in the document."""

    def __init__(self, document: Document, most: int) -> None:
        self._document = document
        self._most = most
        self._count = 0

    def value(self, node: _Node, path: Path) -> Any:
        self._count += 1
        if self._count > self._most:
            self._wrong(node, f"more than {self._most} values, aliases counted as often as they are used")
            raise SpecError(self._document.mistakes)
        self._document.values[path] = node.place
        if node.pairs is not None:
            return self._mapping(node, path)
        if node.text is not None:
            return scalar(node.text) if node.plain else node.text
        entries = [(_NO_KEY, item) for item in node.items]
        items = self._rejoined(entries) if node.flow else entries
        return [self.value(item, (*path, i)) for i, (_, item) in enumerate(items)]

    def _mapping(self, node: _Node, path: Path) -> dict[str, Any]:
        read: dict[str, Any] = {}
        for key, value in self._rejoined(node.pairs or ()) if node.flow else node.pairs or ():
            name = self._key(key)
            if name is None:
                continue
            here = (*path, name)
            if name in read:
                first = self._document.keys[here]
                self._wrong(key, f"duplicate key '{name}', first given at {first.line}:{first.column}")
                continue
            self._document.keys[here] = key.place
            read[name] = self.value(value, here)
        return read

    def _key(self, key: _Node) -> str | None:
        if key.text is None:
            self._wrong(key, "a key must be a name; is a quote missing around { or [?")
            return None
        name = scalar(key.text) if key.plain else key.text
        if name == "<<" and key.plain:
            self._wrong(key, "merge keys (<<) are not read; write the keys out")
            return None
        if not isinstance(name, str):
            self._wrong(key, f"the key {key.text or 'null'} is not a name; write it in quotes, '{key.text}'")
            return None
        return name

    def _rejoined(self, entries: Iterable[_Entry]) -> Iterator[_Entry]:
        """An expression torn apart at its commas is put together again, and its quotes are asked for."""
        rest = deque(entries)
        while rest:
            key, value = rest.popleft()
            pieces = [value.text or ""] if value.plain else []
            while rest and _is_open(pieces) and (piece := _keyless(*rest[0])):
                pieces.append(piece)
                rest.popleft()
            if len(pieces) > 1:
                value = _Node(value.place, text=", ".join(pieces))
                self._wrong(value, f'an expression with a comma needs quotes here: "{value.text}"')
            yield key, value

    def _wrong(self, node: _Node, message: str) -> None:
        self._document.mistakes.append(Mistake(self._document.file, *node.place, message))


def _is_open(pieces: list[str]) -> bool:
    text = "".join(pieces)
    return text.count("(") > text.count(")")


def _keyless(key: _Node, value: _Node) -> str | None:
    """The text of a list item, or of a key in { } that has no value."""
    piece = value if key is _NO_KEY else key if value.text == "" else None
    return piece.text if piece and piece.plain else None


_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NAMED: dict[str, Any] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_NAMED |= {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_NAMED |= dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan)
_NAMED |= {sign + name: math.inf for sign in ("", "+") for name in (".inf", ".Inf", ".INF")}
_NAMED |= {"-" + name: -math.inf for name in (".inf", ".Inf", ".INF")}


def scalar(text: str) -> Any:
    """An unquoted scalar by YAML 1.2's core schema: null, true and false, numbers, else a string."""
    if text in _NAMED:
        return _NAMED[text]
    if _INTEGER.fullmatch(text) and len(text) < 300:
        return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))
    return float(text) if _FLOAT.fullmatch(text) else text
