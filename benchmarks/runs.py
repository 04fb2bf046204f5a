"""Whole runs from shell to shell, beside processes that only import what they import.

python benchmarks/runs.py [ROUNDS]      5 rounds if left out

A run with nothing kept, one of another goal, for which the compiled forms are found again, one of which all
is kept, and `check`. What is imported are the modules of others that a run has in the end; their shares are
as Python tells them with ``-X importtime``.
"""

from __future__ import annotations

import collections
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from startup import ENVIRONMENT, SPEC
from timing import compare

ROUNDS = 5
WORTH = 5.0
"""Milliseconds; packages that take less are not told."""
TOLD = """
import atexit, sys
def tell():
    left_out = {*sys.stdlib_module_names, "orthospec"}
    named = [name for name in sys.modules if name.split(".")[0] not in left_out and name[0] != "_"]
    found = [name for name in named if getattr(sys.modules[name], "__spec__", None)]
    sys.stderr.write("MODULES " + " ".join(found) + chr(10))
atexit.register(tell)
"""
COMMAND = "from orthospec.cli import main; main()"


class Runs:
    """Runs in a folder of their own."""

    def __init__(self, folder: Path) -> None:
        self._out, self._cache = folder / "run", folder / "cache"
        self._goal = 300.0

    def orthospec(self, *arguments: str, before: str = "") -> str:
        """What it says on standard error."""
        command = [sys.executable, "-c", before + COMMAND, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT).stderr

    def run(self, *settings: str, before: str = "") -> str:
        kept = ["--out", str(self._out), "--cache", str(self._cache)]
        return self.orthospec("run", str(SPEC), "-v", *kept, *settings, before=before)

    def anew(self) -> str:
        shutil.rmtree(self._cache, ignore_errors=True)
        return self.run()

    def of_another_goal(self) -> str:
        self._goal += 0.001
        return self.run("--set", f"goals.leg_length.goal={self._goal:.3f} mm")

    def check(self) -> str:
        return self.orthospec("check", str(SPEC))


def importing(modules: list[str], *options: str) -> str:
    """Import modules in a new process; what Python says of it."""
    program = (
        "import sys; from importlib import import_module; list(map(import_module, sys.stdin.read().split()))"
    )
    told = subprocess.run(
        [sys.executable, *options, "-c", program],
        input=" ".join(modules),
        check=True,
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    return told.stderr


def third_party(run: Callable[..., str]) -> list[str]:
    """Modules that are neither ours nor Python's, which a run has imported in the end, in their order."""
    (line,) = re.findall(r"MODULES (.*)", run(before=TOLD))
    return line.split()


def print_shares(modules: list[str], rounds: int) -> None:
    """What each package's own modules take, without what they import from others."""
    shares: dict[str, list[float]] = collections.defaultdict(list)
    roots = {module.split(".")[0] for module in modules}
    for _ in range(rounds):
        each: dict[str, float] = collections.defaultdict(float)
        told = importing(modules, "-X", "importtime")
        for own, name in re.findall(r"import time: +(\d+) \| +\d+ \| +(\S+)", told):
            root = name.split(".")[0]
            each[root if root in roots else "Python's own"] += int(own) / 1e3
        for root, own in each.items():
            shares[root].append(own)
    medians = {root: statistics.median(own) for root, own in shares.items()}
    print(f"\n{'imports of the first run by package':<52}{'ms':>10}")
    for root, own in sorted(medians.items(), key=lambda item: -item[1]):
        if own >= WORTH:
            print(f"  {root:<50}{own:10.0f}")


def print_stages(told: str) -> None:
    print("\nstages of the first run")
    for stage, seconds in re.findall(r"^(\w+): ([\d.]+) s$", told, re.MULTILINE):
        print(f"  {stage:<50}{1e3 * float(seconds):10.0f}")


def main(rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(Path(folder))
        modules = third_party(runs.run)
        kept = third_party(runs.run)
        rivals = {
            "orthospec run, nothing kept": runs.anew,
            "the imports of that": lambda: importing(modules),
            "of another goal, cvxpy's forms kept": runs.of_another_goal,
            "all kept": runs.run,
            "the imports of these": lambda: importing(kept),
            "orthospec check": runs.check,
        }
        runs.anew()
        compare(f"{SPEC.name}, {rounds} rounds", rivals, 1, rounds)
        print_stages(runs.anew())
        print_shares(modules, rounds)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS)
