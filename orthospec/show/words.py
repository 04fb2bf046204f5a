"""The sentences of a result: its status, its bounds, what limits it and at what price."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import expm1

from orthospec.result import FURTHEST, Result
from orthospec.result.model import (
    BracketRecord,
    BranchRecord,
    CardRecord,
    CulpritRecord,
    DesignRecord,
    ErrorRecord,
    FrontSearchRecord,
    LimitRecord,
    NoteRecord,
    PrescribedRecord,
    ProofRecord,
    SearchRecord,
)
from orthospec.show import machine
from orthospec.show.labels import Aim, Asked, Labels
from orthospec.show.numbers import UNKNOWN, Numbers, percent
from orthospec.spec import Variable

SIDES = {"at_least": "at least", "at_most": "at most"}
_NODES = {"meets": "meet", "violates": "violate", "unreachable": "out of reach"}
NO_PLACE = "prescribed cuboid: no place was found for it"
_NO_CHANGE = 1e-9
"""Prices of λ below this are rounding."""


def status(result: Result) -> tuple[str, str]:
    """In which manner, and with which words, the status is told."""
    factor = result.attainment.factor if result.attainment else None
    with_factor = "" if factor is None else f" (λ = {factor:.6g})"
    evaluated = ("good", "every bound holds") if holds(result) else ("bad", "not every bound holds")
    found = result.search is not None and result.search.subproblems > 0
    attained = f"Attained: every bound holds and every goal is met{with_factor}."
    if result.attainment is None:
        attained = "Found: every bound holds. There is no goal, so that any design that holds will do."
    so_far = "the best design found so far" if found else "the design that the search starts from"
    return {
        "attained": ("good", attained),
        "compromise": ("warn", f"Best compromise: every bound holds, not every goal is met{with_factor}."),
        "infeasible": ("bad", "No design was found in which every bound holds."),
        "evaluated": (evaluated[0], f"Evaluated: {evaluated[1]} in the prescribed cuboid."),
        "unfinished": ("warn", f"Stopped before the end; what follows is {so_far}."),
        "failed": ("bad", "A plugin failed; what follows is what could still be found."),
    }[result.status]


def searched(result: Result) -> str:
    """What was searched, and what came of it; nothing where nothing was."""
    if result.search is None:
        return ""
    said = _searched(result.search)
    scale = cuboid_scale(result)
    if scale == 1:
        return said
    return f"{said} The prescribed cuboid is{scaled(scale)}: joints, indices and measures are told over that."


def _searched(search: SearchRecord) -> str:
    said = f"Searched: {counted(search.designs, 'design')} on a coarse grid"
    if not search.refined and not search.starts:
        return f"{said}. What follows is the start."
    if search.refined is not None:
        # Stopped meanwhile, it is not known where they lead.
        places = f", leading to {counted(search.distinct, 'place')}" if search.distinct else ""
        said += f"; {search.refined} refined{places}"
    said += f"; {search.starts} solved to the end."
    if search.least_violation is None:
        return said
    worst = missed(search.least_violation)
    return f"{said} The best point found misses its bounds by {worst}; it is what follows."


def missed(violation: float) -> str:
    """How far bounds are missed at most, by a violation: the logarithm of value over bound."""
    return f"up to {percent(expm1(violation))}"


def counted(number: int, name: str, several: str | None = None) -> str:
    """``1 place``, ``2 places``."""
    return f"{number} {name if number == 1 else several or f'{name}s'}"


def searched_for_front(search: FrontSearchRecord) -> str:
    """What was searched for a Pareto set over catalogues."""
    few = f"{search.branches} combination{'' if search.branches == 1 else 's'}"
    beaten = (
        f"; {search.left_out} more cannot be better than another combination's" if search.left_out else ""
    )
    return f"The best of {few}, which met {search.met} points{beaten}."


def proof(one: ProofRecord, at: str | None) -> tuple[str, str]:
    """In which manner, and with which words, a verdict is told; ``at`` is where it is refuted."""
    within, boxes = percent(one.slack), counted(one.boxes, "box", "boxes")
    if one.verdict == "proved":
        of_all = "" if one.nominal is None else ", for every machine within its tolerances"
        return "good", f"proved: it holds within {within} at every pose{of_all} ({boxes})"
    manner, said = _not_proved(one, at, within, boxes)
    designed = {"proved": "holds", "undecided": "is not refuted"}.get(one.nominal or "")
    return manner, f"{said}; the machine as designed {designed}" if designed else said


def _not_proved(one: ProofRecord, at: str | None, within: str, boxes: str) -> tuple[str, str]:
    name, _, side = (one.condition or "").partition(": ")
    condition = f"{name} ({SIDES[side]})" if side in SIDES else name
    beyond = None if one.excess is None else percent(one.excess)
    if one.verdict == "refuted":
        return "bad", f"refuted: {condition} is missed by {beyond} at {at}"
    if one.why is not None:
        return "warn", f"not proved: nothing is known of {condition} between poses: {one.why}"
    ruled_out = "" if beyond is None else f"; a miss by more than {beyond} is ruled out"
    return "warn", f"not proved within {within} in {boxes}: {condition}{ruled_out}"


def between(ends: BracketRecord) -> str:
    """The proved ends of a scale."""
    least = None if ends.least is None else f"at least {ends.least:.7g}"
    most = None if ends.most is None else f"at most {ends.most:.7g}"
    return " and ".join(part for part in (least, most) if part) or "nothing"


def holds(one: DesignRecord) -> bool:
    """Whether everything asked holds in the prescribed cuboid, or each measure's in its own."""
    workspace = one.workspace
    if workspace.joint is not None:
        return workspace.prescribed is not None and workspace.prescribed.holds
    bounded = [record for record in workspace.measures.values() if record.scale is not None]
    return all(record.prescribed is not None and record.prescribed.holds for record in bounded)


def cuboid_scale(one: DesignRecord) -> float:
    """The scale at which the prescribed cuboid stands, or each measure's own: it is the same for all."""
    workspace = one.workspace
    places = [workspace.prescribed, *(record.prescribed for record in workspace.measures.values())]
    return next((place.scale for place in places if place is not None), 1.0)


def scaled(scale: float) -> str:
    """`` shrunk to 0.26 %`` of a cuboid that stands at another scale than the prescribed one."""
    if scale == 1:
        return ""
    return f" {'shrunk' if scale < 1 else 'grown'} to {100 * scale:.4g} %"


def holding(place: PrescribedRecord) -> tuple[str, str]:
    """In which manner, and with which words, it is told whether all holds in a prescribed cuboid."""
    return ("good", "every bound holds") if place.holds else ("bad", "not every bound holds")


def bounds(numbers: Numbers, given: Mapping[str, float | None], unit: str) -> str:
    """``at least 0.5 and at most 2``."""
    return " and ".join(
        f"{words} {numbers.value(given[side], unit)}"
        for side, words in SIDES.items()
        if given.get(side) is not None
    )


def at_pose(numbers: Numbers, values: Sequence[float | None] | None, unit: str) -> str:
    """A measure's value at a named pose, or its least and greatest over directions."""
    return " ... ".join(dict.fromkeys(numbers.value(value, unit) for value in values or [])) or "out of reach"


def asked(name: str, measure: Asked, numbers: Numbers) -> str:
    """``cutting: deflection, force 100 N, at most 15 um``."""
    own = machine.in_words(measure.keys, measure.fields, numbers)
    return ", ".join(
        filter(None, (f"{name}: {measure.use}", own, bounds(numbers, measure.bounds, measure.unit)))
    )


def weight(number: float, aim: Aim | None) -> str:
    """How much a goal gives way: a number, or as the spec says it."""
    if number == 0:
        return "hard"
    return "relative" if aim is not None and aim.relative else f"{number:.6g}"


def together(limits: Sequence[LimitRecord]) -> list[LimitRecord]:
    """Those with a price, or of which none is known; joint limits of one side and one price as one."""
    alike: dict[tuple[str, ...], list[LimitRecord]] = {}
    for one in limits:
        if not _is_free(one):
            alike.setdefault((one.kind, _numbered(one)[0], one.side or "", price(one)), []).append(one)
    return [_as_one(several) for several in alike.values()]


def _as_one(limits: Sequence[LimitRecord]) -> LimitRecord:
    first = limits[0]
    if len(limits) == 1:
        return first
    stem = _numbered(first)[0]
    numbers = ", ".join(sorted((_numbered(one)[1] for one in limits), key=int))
    return first.model_copy(
        update={"name": f"{stem}.{numbers}", "at": [pose for one in limits for pose in one.at]}
    )


def free(limits: Sequence[LimitRecord]) -> list[LimitRecord]:
    """Those that are reached and neither gain nor cost anything."""
    return [one for one in limits if _is_free(one)]


def reached_too(limits: Sequence[LimitRecord], known: Labels, numbers: Numbers) -> str:
    """Those without a price in one sentence; nothing where there are none."""
    said = [limiting(one, known, numbers) for one in free(limits)]
    return f"reached too, without gain or cost: {'; '.join(said)}" if said else ""


def limits_heading(result: Result) -> str:
    """What is told of the limits: what they hold back, or that they conflict."""
    conflict = result.status == "infeasible" or bool(result.search and result.search.conflicts)
    return "What conflicts" if conflict else "What limits the design"


def _is_free(limit: LimitRecord) -> bool:
    return all(price is not None and price < _NO_CHANGE for price in (limit.gain, limit.cost))


def _numbered(limit: LimitRecord) -> tuple[str, str]:
    """``joint_limits.0.at_most`` as ``joint_limits`` and ``0``; no number for what is not one of several."""
    stem, _, number = limit.name.removesuffix(f".{limit.side}").rpartition(".")
    return (stem, number) if limit.kind == "joint" and number.isdigit() else (limit.name, "")


def limiting(limit: LimitRecord, known: Labels, numbers: Numbers) -> str:
    """What binds, with the value of its bound where that is known."""
    side = SIDES.get(limit.side or "", "")
    if limit.kind == "goal":
        aim = known.goals.get(limit.name)
        return f"goal {limit.name}" + (f": {aim.words}" if aim else "")
    if limit.kind == "joint":
        return f"reach: {limit.name.removesuffix(f'.{limit.side}')} {side}"
    end, unit = None, UNKNOWN
    if limit.kind == "variable" and limit.name in known.ranges:
        variable, unit = known.ranges[limit.name], known.variables.get(limit.name, UNKNOWN)
        end = variable.min if limit.side == "at_least" else variable.max
    elif limit.name in known.measures:
        asked = known.measures[limit.name]
        end, unit = asked.bounds.get(limit.side or ""), asked.unit
    kind = "variable" if limit.kind == "variable" else "measure"
    return f"{kind} {limit.name}: {side} {'' if end is None else numbers.value(end, unit)}"


def price(limit: LimitRecord) -> str:
    """What one per cent is worth, in λ; nothing where neither side has a price."""
    looser, tighter = prices(limit)
    return f"1 % looser: {looser}; 1 % tighter: {tighter}" if looser else ""


def prices(limit: LimitRecord) -> tuple[str, str]:
    """What one per cent looser gains and one per cent tighter costs; nothing where neither is known."""
    if limit.gain is None and limit.cost is None:
        return "", ""
    return _moved(limit.gain, "no gain", "λ falls by"), _moved(limit.cost, "no cost", "λ rises by")


def within(variable: Variable, unit: str, numbers: Numbers) -> str:
    """The range of a variable, or its choices."""
    if variable.choices:
        return f"one of {', '.join(numbers.value(choice, unit) for choice in variable.choices)}"
    return f"within {numbers.interval(variable.min, variable.max, unit)}"


def branch(one: BranchRecord) -> str:
    """What a combination of choices came to."""
    if one.found:
        return "found" if one.factor is None else f"{one.factor:.6g}"
    by = "" if one.least_violation is None else f", misses by {missed(one.least_violation)}"
    return f"no design found{by}"


def behind(one: BranchRecord, best: BranchRecord) -> str:
    """How far a combination of choices is behind the one that was taken."""
    if one is best:
        return "taken" if one.found else ""
    if one.cost is None or one.cost < _NO_CHANGE:
        return "as good" if one.found else ""
    return f"λ rises by {one.cost:.3g}"


def way_out(culprit: CulpritRecord, known: Labels, numbers: Numbers) -> tuple[str, str]:
    """A condition of a conflict, and by how much it alone would have to give way."""
    said = limiting(LimitRecord(kind=culprit.kind, name=culprit.name, side=culprit.side), known, numbers)
    if "by" not in culprit.model_fields_set:
        return said, "stopped before it was known how far it alone would have to give way"
    if culprit.by is None:
        tried = f", by up to {FURTHEST:.0f} times its range" if culprit.kind == "variable" else ""
        return said, f"no design was found by loosening it alone{tried}"
    whole = {"variable": "of its range", "goal": "of the goal"}.get(culprit.kind, "")
    part = f"by {percent(culprit.by)} {whole}".rstrip()
    if culprit.needed is None:
        return said, f"alone: {part}"
    unit = {
        "variable": known.variables.get(culprit.name, UNKNOWN),
        "bound": known.measures[culprit.name].unit if culprit.name in known.measures else UNKNOWN,
        "goal": known.goals[culprit.name].unit if culprit.name in known.goals else UNKNOWN,
    }.get(culprit.kind, UNKNOWN)
    return said, f"alone: to {numbers.value(culprit.needed, unit)}, {part}"


def conflict(card: CardRecord) -> str:
    """How far the conditions of a conflict were taken apart."""
    each_alone = card.irreducible and all(one.by is not None for one in card.conflict)
    few = "; without any one of them a design was found" if each_alone else ""
    return f"These cannot all hold{few}."


def ways_out(card: CardRecord) -> str:
    """What else would do."""
    ways = []
    if card.together is not None:
        ways.append(f"all of these by {percent(card.together)}")
    if card.scale is not None:
        ways.append(f"a cuboid of {100 * card.scale:.4g} % of the size")
    return f"Or: {', or '.join(ways)}." if ways else ""


def told(one: ErrorRecord | NoteRecord) -> str:
    """A failure or a note, with its place in the spec."""
    return f"{one.name}{f' ({one.place})' if one.place else ''}: {one.message}"


def _moved(change: float | None, nothing: str, moves: str) -> str:
    if change is None:
        return "no design found"
    return nothing if change < _NO_CHANGE else f"{moves} {change:.3g}"


def nodes(counts: Mapping[str, int]) -> str:
    """``391114 meet, 620432 violate, 1236545 out of reach``."""
    return ", ".join(f"{count} {_NODES.get(state, state)}" for state, count in counts.items() if count)
