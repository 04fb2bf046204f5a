"""What a command takes before it does its work, beside processes that do nothing else but start.

python benchmarks/startup.py [ROUNDS]      21 rounds if left out

Each is a process of its own. They take turns, so that a busy spell meets all of them, and keep the bytecode
of what they import, as an installed package does.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

from orthospec.cli import app

ROUNDS = 21
SPEC = Path(__file__).parents[1] / "specs" / "orthoglide-200.yaml"
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
OURS = "from orthospec.cli import main; main()"
BARE = """
import typer
app = typer.Typer(rich_markup_mode=None)
for number in range({commands}):
    @app.command(f"command-{{number}}")
    def command() -> None:
        "One of many."
app()
"""
USED = """
from typing import Annotated
import pydantic, typer, yaml
app = typer.Typer(rich_markup_mode=None)
class Model(pydantic.BaseModel):
    title: str
@app.command()
def command(files: Annotated[list[str], typer.Argument()]) -> None:
    with open(files[0]) as file:
        print(Model.model_validate(yaml.load(file, yaml.CSafeLoader)))
app()
"""
"""The least program that takes a file, reads YAML and checks one key of it."""

Program = tuple[str, ...]
Times = tuple[float, float]


def comparisons() -> tuple[tuple[str, Program, dict[str, Program]], ...]:
    """What python runs: a command, and beside it what its time is divided by."""
    bare = BARE.format(commands=len(app.registered_commands))
    return (
        (
            "orthospec --help",
            ("-c", OURS, "--help"),
            {"a bare typer program with as many commands": ("-c", bare, "--help")},
        ),
        (
            f"orthospec check {SPEC.name}",
            ("-c", OURS, "check", str(SPEC)),
            {
                "import typer, pydantic, yaml": ("-c", "import typer, pydantic, yaml"),
                "each of these used once": ("-c", USED, str(SPEC)),
            },
        ),
    )


def run(program: Program) -> Times:
    """Milliseconds of the wall clock, and of the processor."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    command = [sys.executable, *program]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=ENVIRONMENT)
    passed = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e3 * passed, 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def row(name: str, times: list[Times], ours: list[Times]) -> str:
    """Median and quartiles, and our medians divided by these."""
    low, middle, high = statistics.quantiles([wall for wall, _ in times], n=4)
    busy = statistics.median(cpu for _, cpu in times)
    slower = statistics.median(wall for wall, _ in ours) / middle
    busier = statistics.median(cpu for _, cpu in ours) / busy
    return f"{name:<46}{middle:6.0f}{f'{low:.0f} ... {high:.0f}':>14}{busy:8.0f}{slower:8.2f}{busier:8.2f}"


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    programs = {
        name: program
        for ours, command, others in comparisons()
        for name, program in ((ours, command), *others.items())
    }
    for program in programs.values():
        run(program)  # its files come from the disk, and its bytecode is written
    taken: dict[str, list[Times]] = {name: [] for name in programs}
    for _ in range(rounds):
        for name, program in programs.items():
            taken[name].append(run(program))
    print(f"{f'{rounds} rounds':<46}{'ms':>6}{'quartiles':>14}{'CPU ms':>8}{'ours by':>8}{'by CPU':>8}")
    for ours, _, others in comparisons():
        for name in (*others, ours):
            print(row(name, taken[name], taken[ours]))


if __name__ == "__main__":
    main()
