"""Runs the kernels' tests of a tree on its own sanitised extension: python sanitised.py TREE."""

import sys
from pathlib import Path

import pytest

tree = Path(sys.argv[1]).resolve()
sys.path.insert(0, str(tree))

from orthospec.kernels import _kernels  # noqa: E402

binary = Path(_kernels.__file__).resolve()
assert binary.is_relative_to(tree), f"{binary} is not of {tree}"
assert b"__asan_report" in binary.read_bytes(), f"{binary} is not sanitised"
print(f"testing {binary}", flush=True)
tests = [
    str(tree / "tests" / name)
    for name in (
        "test_kernels.py",
        "test_largest_cubes.py",
        "test_chain_kernel.py",
        "test_small_matrices.py",
        "test_fused.py",
        "test_instruction_sets.py",
    )
]
options = [
    f"--rootdir={tree}",
    "-p",
    "no:cacheprovider",
    "--capture=no",
]  # a sanitiser's last words are not lost
sys.exit(pytest.main([*tests, *options]))
