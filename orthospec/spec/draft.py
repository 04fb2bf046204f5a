"""A spec while it is being read: its keys, what is known of its names so far, and its mistakes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from orthospec.errors import Mistake, SpecError
from orthospec.quantities import Expression
from orthospec.quantities.expressions import unknown_name
from orthospec.quantities.fields import read
from orthospec.spec.document import Document, Path
from orthospec.spec.model import SpecKeys
from orthospec.spec.wording import problems

if TYPE_CHECKING:
    from orthospec.manipulators import Manipulator
    from orthospec.measures import Measure

_BY_NAME = ("variables", "measures", "goals", "poses")
"""Sections of entries with names: one that is wrong does not hide the others."""
_STAND_INS: dict[str, Any] = {"orthospec": 1, "manipulator": {}, "workspace": {"size": (1, 1)}}


class Draft:
    """Collects mistakes; each stage of `orthospec.spec.resolve` adds what it finds out."""

    def __init__(self, document: Document) -> None:
        """Check the form of all keys; entries that are wrong are left out of `keys`."""
        self.document = document
        self.mistakes: list[Mistake] = list(document.mistakes)
        self.left_out: set[Path] = set()
        self.keys = self._checked(document.data)
        self.names = frozenset(self._given("variables"))
        """All variables that the file declares, well or not."""
        self.machine: type[Manipulator] | None = None
        self.measures: dict[str, type[Measure] | None] = dict.fromkeys(self._given("measures"))
        """The measures by the user's names; None where the class is not known."""

    def wrong(self, path: Path, message: str, *, at_key: bool = False) -> None:
        """Note a mistake."""
        self.mistakes.append(self.document.mistake(path, message, at_key=at_key))

    def is_known(self, section: str) -> bool:
        """Whether a section is given, or may be left out, and has no mistake of form."""
        return (section,) not in self.left_out

    def amount(self, path: Path, given: Any, unit: str | None) -> float | None:
        """A number or quantity in SI where no variable may stand; None, and a mistake, for anything else."""
        reading = self.reading(path, given, unit, ())
        return reading if isinstance(reading, float) or reading is None else self._constant(path, reading)

    def reading(
        self, path: Path, given: Any, unit: str | None, names: Iterable[str] | None = None
    ) -> float | Expression | None:
        """A number, quantity or expression over the variables (or over ``names``); None after a mistake."""
        try:
            reading = read(given, unit)
        except ValueError as error:
            self.wrong(path, str(error))
            return None
        if not isinstance(reading, Expression):
            return reading
        if reading.names and names is not None and not names:
            self.wrong(path, f"'{given}' is not a number or quantity, and no variable can stand here")
            return None
        return reading if self.knows(path, reading, self.names if names is None else names) else None

    def knows(self, path: Path, expression: Expression, names: Iterable[str]) -> bool:
        """Whether an expression uses known names only; else each unknown one is a mistake."""
        unknown = sorted(expression.names - set(names))
        for name in unknown:
            self.wrong(path, unknown_name(name, names))
        return not unknown

    def _constant(self, path: Path, expression: Expression) -> float | None:
        try:
            return expression.value({})
        except ValueError as error:
            self.wrong(path, str(error))
            return None

    def _given(self, section: str) -> Mapping[str, Any]:
        given = self.document.data.get(section)
        return given if isinstance(given, dict) else {}

    def _checked(self, data: Any) -> SpecKeys:
        if not isinstance(data, dict):
            self.wrong((), "a spec is a mapping that starts with 'orthospec: 1'")
            raise SpecError(self.mistakes)
        try:
            return SpecKeys.model_validate(data)
        except ValidationError as error:
            for problem in problems(error, data, SpecKeys):
                self.wrong(problem.path, problem.message, at_key=problem.at_key)
                if problem.path:
                    self.left_out.add(problem.path[: 2 if problem.path[0] in _BY_NAME else 1])
            self.left_out |= {(name,) for name in _STAND_INS if name not in data}
        return SpecKeys.model_validate(self._pruned(data))

    def _pruned(self, data: Mapping[str, Any]) -> dict[str, Any]:
        pruned = {name: given for name, given in data.items() if (name,) not in self.left_out}
        for name in _BY_NAME:
            if isinstance(pruned.get(name), dict):
                pruned[name] = {
                    key: given for key, given in pruned[name].items() if (name, key) not in self.left_out
                }
        return {**_STAND_INS, **pruned}
