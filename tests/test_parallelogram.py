"""The parallelogram's closed form beside its two chains, and beside a beam's own formula."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.mechanics.parallelogram import parallelogram_compliance, parallelogram_stiffness

LENGTH, SPACING = 0.31, 0.08
AXIAL, TORSION, BENDING = 2e-9, 3e-4, 2e-4  # 1/EA, 1/GJ, 1/EI_y
seeds = st.integers(0, 2**32 - 1)


def beam():
    compliance = np.diag(
        [
            AXIAL * LENGTH,
            7e-4 * LENGTH**3 / 3,
            BENDING * LENGTH**3 / 3,
            TORSION * LENGTH,
            BENDING * LENGTH,
            7e-4 * LENGTH,
        ]
    )
    compliance[1, 5] = compliance[5, 1] = 7e-4 * LENGTH**2 / 2
    compliance[2, 4] = compliance[4, 2] = -BENDING * LENGTH**2 / 2
    return compliance


def at(angle, spacing=SPACING):
    return {"spacing": spacing, "cos": np.cos(angle), "sin": np.sin(angle)}


def transmitted(angle):
    """The wrenches that a leg transmits: a force along −x, a moment about t, a moment about z."""
    wrenches = np.zeros((len(angle), 3, 6))
    wrenches[:, 0, 0] = -1
    wrenches[:, 1, 3], wrenches[:, 1, 4] = np.cos(angle), -np.sin(angle)
    wrenches[:, 2, 5] = 1
    return wrenches


def by_two_chains(bar, angle, spacing=SPACING):
    inverse = np.linalg.pinv(parallelogram_stiffness(bar, **at(angle, spacing)), rcond=1e-13, hermitian=True)
    wrenches = transmitted(angle)
    return wrenches @ inverse @ np.swapaxes(wrenches, 1, 2)


ANGLES = np.linspace(-1.3, 1.3, 27)


def test_closed_form_equals_two_chains_for_beams():
    found, expected = parallelogram_compliance(beam(), **at(ANGLES)), by_two_chains(beam(), ANGLES)
    scale = np.sqrt(np.einsum("nii->ni", expected))
    np.testing.assert_allclose(
        found / (scale[:, :, None] * scale[:, None, :]),
        expected / (scale[:, :, None] * scale[:, None, :]),
        rtol=0,
        atol=1e-12,
    )


@settings(max_examples=100, deadline=None)
@given(seeds, st.floats(0.5, 3.0))
def test_closed_form_equals_two_chains_for_any_bar(seed, spacing):
    axes, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((6, 6)))
    bar = (axes * np.geomspace(1, 100, 6)) @ axes.T
    found, expected = (
        parallelogram_compliance(bar, **at(ANGLES, spacing)),
        by_two_chains(bar, ANGLES, spacing),
    )
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_bars_that_differ_from_pose_to_pose_are_each_what_they_are_alone():
    factors = np.linspace(0.5, 2, len(ANGLES))
    found = parallelogram_compliance(factors[:, None, None] * beam(), **at(ANGLES))
    for i, factor in enumerate(factors):
        alone = parallelogram_compliance(factor * beam(), **at(ANGLES[i : i + 1]))
        np.testing.assert_allclose(found[i], alone[0], rtol=1e-13)


def test_stiffness_is_that_of_the_textbook_for_beams():
    cos, sin = np.cos(ANGLES), np.sin(ANGLES)
    k11, k44 = 1 / (AXIAL * LENGTH), 1 / (TORSION * LENGTH)
    block = np.linalg.inv(beam()[np.ix_([2, 4], [2, 4])])
    k33, k35, k55 = block[0, 0], block[0, 1], block[1, 1]
    expected = np.zeros((len(ANGLES), 6, 6))
    expected[:, 0, 0], expected[:, 2, 2] = 2 * k11, 2 * k33
    expected[:, 3, 3] = 2 * k44 + SPACING**2 * cos**2 * k33 / 2
    expected[:, 4, 4] = 2 * k55 + SPACING**2 * sin**2 * k33 / 2
    expected[:, 5, 5] = SPACING**2 * cos**2 * k11 / 2
    expected[:, 2, 4] = expected[:, 4, 2] = 2 * k35
    expected[:, 3, 4] = expected[:, 4, 3] = -(SPACING**2) * sin * cos * k33 / 2
    found = parallelogram_stiffness(beam(), **at(ANGLES))
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * k11)


@pytest.mark.parametrize(("angle", "rank"), [(0.0, 5), (0.7, 5), (np.pi / 2, 4), (-np.pi / 2, 4)])
def test_stiffness_has_rank_5_and_4_where_the_bars_lie_in_one_line(angle, rank):
    stiffness = parallelogram_stiffness(np.eye(6), **at(np.array([angle]), spacing=1.0))
    assert np.linalg.matrix_rank(stiffness[0], tol=1e-9) == rank


def test_beams_resist_each_wrench_by_itself():
    found = parallelogram_compliance(beam(), **at(ANGLES))
    about_t = LENGTH * (TORSION * np.cos(ANGLES) ** 2 + BENDING * np.sin(ANGLES) ** 2)
    shear = BENDING * LENGTH**3 / 12
    expected = np.zeros_like(found)
    expected[:, 0, 0] = AXIAL * LENGTH / 2
    expected[:, 1, 1] = 1 / (2 / about_t + SPACING**2 / 2 / shear)
    expected[:, 2, 2] = 2 * AXIAL * LENGTH / (SPACING * np.cos(ANGLES)) ** 2
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=0)


def test_bending_in_the_plane_does_not_enter():
    soft = beam()
    soft[1], soft[:, 1], soft[5], soft[:, 5] = 0.0, 0.0, 0.0, 0.0
    np.testing.assert_array_equal(
        parallelogram_compliance(soft, **at(ANGLES)), parallelogram_compliance(beam(), **at(ANGLES))
    )


def test_of_rigid_bars_is_rigid():
    assert not parallelogram_compliance(np.zeros((6, 6)), **at(ANGLES)).any()


def test_of_bars_rigid_but_for_stretch_is_the_limit_of_slender_ones():
    stretching = np.diag([1e-9, 0, 0, 0, 0, 0])
    found = parallelogram_compliance(stretching, **at(np.array([0.5])))[0]
    expected = np.diag([0.5e-9, 0, 2e-9 / (SPACING * np.cos(0.5)) ** 2])
    np.testing.assert_allclose(found, expected, rtol=1e-15)
