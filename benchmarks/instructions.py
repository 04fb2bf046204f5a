"""How many instructions the kernels take, which repeats where seconds do not; needs valgrind.

python benchmarks/instructions.py

Callgrind counts those of a process that calls a kernel some more times than another does. Where it has no
AVX-512, these are the kernels for x86-64-v3.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile

PREPARE = """
import numpy as np
from orthospec import kernels
from orthospec.intervals import Boxes, fused
random = np.random.default_rng(1)
axis = np.linspace(-1.0, 1.0, 100)
x, y, z = np.meshgrid(axis, axis, axis, indexing="ij", sparse=True)
squares = x**2 + y**2 + z**2
ball, noise = squares <= 0.9, random.random(squares.shape) < 0.9
small, spatial = random.standard_normal((20000, 3, 3)), random.standard_normal((5000, 6, 6))
halves = random.standard_normal((5000, 3, 2, 2))
legs = random.uniform(0.5, 1.0, (3, 21)) + 2.0 * np.isin(np.arange(21), [11, 14, 16, 17, 19])
directions = random.standard_normal((3, 3, 5000))
lo = random.uniform(1.0, 2.0, (512, 3))
poses = Boxes(lo, lo + 1e-3).poses
over_boxes = np.stack([np.stack([poses[:, (i + j) % 3] + j for j in range(6)], 1) for i in range(6)], 1)
chains = halves @ halves.swapaxes(2, 3) + np.eye(2), random.standard_normal((5000, 3, 2, 6))
"""
KERNELS = {
    "largest_cube of a ball": ("kernels.largest_cube(ball)", 100**3, "node"),
    "largest_cube of noise": ("kernels.largest_cube(noise)", 100**3, "node"),
    "largest_cube of a field": (
        "kernels.largest_cube(kernels.Within(squares.ravel(), squares.shape, at_most=0.9))",
        100**3,
        "node",
    ),
    "cube_sizes of a ball": ("kernels.cube_sizes(ball)", 100**3, "node"),
    "cube_sizes of noise": ("kernels.cube_sizes(noise)", 100**3, "node"),
    "symmetric_eigenvalues, 3 x 3": ("kernels.symmetric_eigenvalues(small)", 20000, "matrix"),
    "singular_values, 3 x 3": ("kernels.singular_values(small)", 20000, "matrix"),
    "chain_compliance, 3 chains of 2": ("kernels.chain_compliance(*chains)", 5000, "platform"),
    "legs_compliance, 3 parallelograms": (
        "kernels.legs_compliance(legs, np.zeros((3, 6, 6)), directions)",
        5000,
        "platform",
    ),
    "product of intervals": ("fused.multiply(over_boxes, over_boxes)", 512 * 36, "entry"),
    "matrix product of intervals, 6 x 6": (
        "fused.contract('nij', 'njk', 'nik', over_boxes, over_boxes)",
        512 * 36,
        "entry",
    ),
}
CALLS = 5
ENVIRONMENT = {**os.environ, "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1"}


def instructions(program: str) -> int:
    """Of a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        counting = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out"]
        command = [*counting, sys.executable, "-c", program]
        told = subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT).stderr
    (count,) = re.findall(r"Collected : (\d+)", told)
    return int(count)


def main() -> None:
    # A first call has its modules imported and its instruction set chosen.
    print(f"{'instructions of':<40}{'a call':>14}{'each':>10}")
    for name, (call, count, each) in KERNELS.items():
        once, often = (instructions(f"{PREPARE}\nfor _ in range({n}): {call}") for n in (1, 1 + CALLS))
        found = (often - once) / CALLS
        print(f"{name:<40}{found:14.0f}{found / count:10.2f} a {each}", flush=True)


if __name__ == "__main__":
    main()
