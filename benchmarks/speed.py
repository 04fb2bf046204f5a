"""All that is told of speed, one part after the other, each in a process of its own.

python benchmarks/speed.py [PART...]      all of them takes half an hour; needs orthospec[bench]

Ratios are within a part's own run. Nothing else should be running.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from orthospec.kernels import instruction_set

PARTS = {
    "kernels": "kernels beside NumPy, SciPy, numba and one read of memory",
    "instructions": "instructions of the kernels",
    "fields": "fields beside NumPy and numba; growth with nodes and measures",
    "stiffness": "stiffness fields and nested cuboids beside eq. 6 by NumPy",
    "subproblems": "subproblems; growth with variables",
    "startup": "--help and check beside processes that only start",
    "runs": "whole runs beside their imports",
}
LIBRARIES = ("numpy", "scipy", "cvxpy", "clarabel", "numba")


def processor() -> str:
    """Its name, as Linux tells it, else as Python does."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parts = asked.parse_args().parts or list(PARTS)
    if unknown := set(parts) - set(PARTS):
        asked.error(f"no part {', '.join(sorted(unknown))}: there are {', '.join(PARTS)}")
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    print(f"{processor()}, {os.cpu_count()} cores, kernels for {instruction_set()}")
    print(f"{platform.platform()}, Python {platform.python_version()}, {libraries}")
    for part in parts:
        print(f"\n== {PARTS[part]}", flush=True)
        if part == "instructions" and shutil.which("valgrind") is None:
            print("left out: valgrind is not installed")
            continue
        program = Path(__file__).with_name(f"{part}.py")
        if subprocess.run([sys.executable, str(program)], check=False).returncode:
            print(f"{part} failed")


if __name__ == "__main__":
    main()
