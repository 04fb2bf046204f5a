"""Prices against the moved problem searched anew.

python benchmarks/prices.py [SPEC ...]        specs/ that have design variables, if none is given

Each bound, end of a range and goal that a result gives a price is moved by one per cent to either side in the
spec itself, and the whole search run again from all its starts. Told are λ's change and the price; a
difference above one per cent is marked.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from orthospec.optimise import solve
from orthospec.optimise.branch import hunt_branches
from orthospec.optimise.workers import Here
from orthospec.result import Limit
from orthospec.spec import Design, Spec, load_spec

SPECS = Path(__file__).parents[1] / "specs"
NAMES = (
    "orthoglide-200",
    "orthoglide-1x1x0.8",
    "orthoglide-1x1x0.8-sum",
    "orthoglide-1x1x0.8-third-hard",
    "orthoglide-condition",
    "orthoglide-scale",
    "linear-delta-300",
    "orthoglide-200-drives",
)
PERCENT = 0.01
NOISE = 3e-8
"""Changes of λ below this are those of its last digits."""


def moved(spec: Spec, design: Design, limit: Limit, part: float) -> list[str]:
    """Overrides that loosen one condition by a part of itself; a joint limit has no number of its own."""
    if limit.kind == "bound":
        bound = next(one for one in design.demands if one.name == limit.name).bounds[str(limit.side)]
        sign = 1 if limit.side == "at_most" else -1
        return [f"measures.{limit.name}.{limit.side}={bound * (1 + sign * part)!r}"]
    if limit.kind == "variable":
        one = spec.variables[limit.name]
        step = part * (one.max - one.min)
        low = one.min - step * (limit.side == "at_least")
        high = one.max + step * (limit.side == "at_most")
        start = min(max(one.start, low), high)
        return [f"variables.{limit.name}={{min: {low!r}, max: {high!r}, start: {start!r}}}"]
    if limit.kind == "goal":
        goal = next(one for one in design.goals if one.name == limit.name)
        sign = -1 if goal.sense == "maximise" else 1
        aim = goal.goal + sign * part * abs(goal.goal)
        return [f"goals.{limit.name}.goal={aim!r}", f"goals.{limit.name}.weight={goal.weight!r}"]
    return []


def changes(path: Path) -> Iterator[tuple[Limit, str, float, float]]:
    """Each price, by limit and kind, with the change of λ when the search is run anew."""
    spec = load_spec(path)
    finding = solve(spec).finding
    assert finding.attainment is not None
    assert finding.attainment.factor is not None
    best = finding.attainment.factor
    for limit in finding.limits:
        for kind, price, part in (("gain", limit.gain, PERCENT), ("cost", limit.cost, -PERCENT)):
            settings = moved(spec, finding.design, limit, part)
            if price is None or not settings:
                continue
            anew = hunt_branches(load_spec(path, settings), Here()).best[1].best
            if anew is not None and anew.feasible:
                factor = anew.factor * anew.unit
                yield limit, kind, price, best - factor if kind == "gain" else factor - best


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("specs", nargs="*", type=Path, metavar="SPEC")
    paths = asked.parse_args().specs or [SPECS / f"{name}.yaml" for name in NAMES]
    print(f"{'spec':30} {'moved':34} {'':5} {'price':>13} {'searched anew':>14} {'difference':>11}")
    for path in paths:
        for limit, kind, price, change in changes(path):
            what = f"{limit.kind} {limit.name} {limit.side or ''}"
            off = abs(price - change) / max(abs(change), NOISE)
            far = off > PERCENT and abs(price - change) > NOISE
            print(
                f"{path.stem:30} {what:34} {kind:5} {price:13.6e} {change:14.6e} {off:11.1e}{' !' * far}",
                flush=True,
            )


if __name__ == "__main__":
    main()
