"""Compliance of bars: textbook deflections, bars in series, and what is no compliance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orthospec.mechanics.bars import cantilever, is_compliance, is_symmetric
from orthospec.mechanics.materials import TABLE
from orthospec.mechanics.sections import rectangle
from orthospec.mechanics.virtual_joints import spring_at

STEEL = TABLE["steel"]
SECTION = rectangle(height=0.03, width=0.02)
LENGTH = 0.4
lengths = st.floats(0.05, 3.0)
turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda r: Rotation.from_rotvec(r).as_matrix())


def moved(compliance, lever):
    """The compliance at a point away by ``lever``, rigidly joined: t' = t + r × lever."""
    x, y, z = lever
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    shift = np.eye(6)
    shift[:3, 3:] = -cross
    return shift @ compliance @ shift.T


def turned(compliance, axes):
    """The compliance in the frame in which the rows of ``axes`` are written."""
    return spring_at(compliance, axes[None], np.zeros((1, 3)))[0]


def test_deflections_are_the_textbook_ones():
    C = cantilever(SECTION, STEEL, LENGTH)
    F, M, E = 100.0, 7.0, STEEL.E
    pulled, pushed_y, pushed_z, twisted, bent_y, bent_z = (C[:, i] for i in range(6))
    assert F * pulled[0] == pytest.approx(F * LENGTH / (E * SECTION.area))
    assert F * pushed_y[1] == pytest.approx(F * LENGTH**3 / (3 * E * SECTION.Iz))
    assert F * pushed_y[5] == pytest.approx(F * LENGTH**2 / (2 * E * SECTION.Iz))
    assert F * pushed_z[2] == pytest.approx(F * LENGTH**3 / (3 * E * SECTION.Iy))
    assert F * pushed_z[4] == pytest.approx(-F * LENGTH**2 / (2 * E * SECTION.Iy))
    assert M * twisted[3] == pytest.approx(M * LENGTH / (STEEL.G * SECTION.J))
    assert M * bent_y[4] == pytest.approx(M * LENGTH / (E * SECTION.Iy))
    assert M * bent_y[2] == pytest.approx(-M * LENGTH**2 / (2 * E * SECTION.Iy))
    assert M * bent_z[1] == pytest.approx(M * LENGTH**2 / (2 * E * SECTION.Iz))


def test_bars_of_several_lengths_have_the_compliance_of_each():
    several = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    found = cantilever(SECTION, STEEL, several)
    assert found.shape == (2, 3, 6, 6)
    for place in np.ndindex(2, 3):
        np.testing.assert_allclose(
            found[place], cantilever(SECTION, STEEL, float(several[place])), rtol=1e-15
        )


@given(lengths, lengths)
def test_two_bars_end_to_end_are_one_long_bar(one, other):
    first, second = cantilever(SECTION, STEEL, one), cantilever(SECTION, STEEL, other)
    whole = moved(first, (other, 0, 0)) + second
    expected = cantilever(SECTION, STEEL, one + other)
    np.testing.assert_allclose(whole, expected, rtol=1e-12, atol=1e-30)


@given(lengths, st.floats(0.2, 5.0))
def test_a_bar_scaled_as_a_whole_is_stiffer_in_translation_by_its_scale(length, factor):
    small = cantilever(SECTION, STEEL, length)
    large = cantilever(rectangle(height=0.03 * factor, width=0.02 * factor), STEEL, length * factor)
    powers = np.array([[1, 2], [2, 3]]).repeat(3, axis=0).repeat(3, axis=1)
    np.testing.assert_allclose(large * factor**powers, small, rtol=1e-12)


@given(lengths, turns, st.floats(1e-6, 1e6))
def test_bars_have_compliances_in_any_frame_and_unit_of_length(length, axes, unit):
    C = turned(cantilever(SECTION, STEEL, length), axes)
    scale = np.diag([unit] * 3 + [1.0] * 3)
    assert is_compliance(scale @ C @ scale)


def test_rigid_bars_and_bars_rigid_in_some_directions_have_compliances():
    assert is_compliance(np.zeros((6, 6)))
    assert is_compliance(np.diag([0.0, 1e-7, 0.0, 0.0, 1e-3, 0.0]))


def test_a_matrix_as_printed_with_seven_digits_is_a_compliance():
    C = turned(cantilever(SECTION, STEEL, LENGTH), Rotation.from_rotvec([0.3, 0.8, -0.4]).as_matrix())
    printed = np.array([[float(f"{value:.6e}") for value in row] for row in C])
    assert is_compliance(printed)


def test_what_gives_energy_back_is_no_compliance():
    C = cantilever(SECTION, STEEL, LENGTH)
    swapped = C.copy()
    swapped[1, 5] = swapped[5, 1] = 1.3 * C[1, 5]
    negative = np.diag([1.0, 1, 1, 1, 1, -1e-9])
    coupled_to_rigid = np.zeros((6, 6))
    coupled_to_rigid[0, 1] = coupled_to_rigid[1, 0] = 1e-9
    for matrix in (swapped, negative, coupled_to_rigid, -C):
        assert not is_compliance(matrix)


def test_an_entry_without_its_mirror_image_is_not_symmetric():
    C = cantilever(SECTION, STEEL, LENGTH)
    C[1, 5] *= 1.001
    assert not is_symmetric(C)
    assert not is_compliance(C)
