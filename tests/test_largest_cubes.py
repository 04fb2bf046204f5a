"""Size and places of the largest cubes equal those of the twin, from masks and from bounds on fields."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orthospec.kernels import Within, _kernels, cube_ends, cube_sizes, largest_cube, twin

OUTSIDE = np.array([np.nan, -np.inf, np.inf, -1.0, 2.0, np.nextafter(1.0, 2.0), np.nextafter(0.0, -1.0)])
INSIDE = np.array([0.0, -0.0, 0.3, 1.0])

seeds = st.integers(0, 2**32 - 1)
densities = st.sampled_from([0.0, 0.3, 0.7, 0.9, 0.97, 1.0])
shapes = st.lists(st.integers(1, 9), min_size=2, max_size=3)


@st.composite
def masks(draw, shapes=shapes):
    shape, random = tuple(draw(shapes)), np.random.default_rng(draw(seeds))
    return random.random(shape) < draw(densities)


def field_of(mask, seed=0):
    """A field that is within 0 and 1 where the mask is set."""
    random = np.random.default_rng(seed)
    return np.where(mask, random.choice(INSIDE, mask.shape), random.choice(OUTSIDE, mask.shape)).ravel()


def two_sided(mask, seed=0):
    """Least and greatest values, of which one or both leave the bounds where the mask is not set."""
    random = np.random.default_rng(seed)
    low, high = random.choice([0.0, 0.5], mask.shape), random.choice([0.5, 1.0], mask.shape)
    side = random.integers(1, 4, mask.shape)
    low = np.where(~mask & (side & 1 > 0), -0.5, low)
    high = np.where(~mask & (side & 2 > 0), random.choice([np.nan, 1.5], mask.shape), high)
    return np.column_stack([low.ravel(), high.ravel()])


def assert_equal_to_the_twin(nodes, mask):
    edge = twin.largest_cube(mask)
    assert largest_cube(nodes) == edge
    for one in {max(edge, 1), max(edge - 1, 1), (edge + 1) // 2 or 1}:
        np.testing.assert_array_equal(cube_ends(nodes, one), twin.cube_ends(mask, one))


@st.composite
def solids(draw):
    """Some boxes and balls with a few holes: where large cubes are, and where a coarse look may be wrong."""
    random = np.random.default_rng(draw(seeds))
    shape = random.integers(20, 75, 3)
    nodes = np.indices(shape)
    mask = np.zeros(shape, dtype=bool)
    for _ in range(draw(st.integers(1, 3))):
        centre, radius = random.uniform(0, shape), random.uniform(5, 45)
        ways = np.abs(nodes - centre[:, None, None, None])
        size = ways.max(axis=0) if draw(st.booleans()) else np.sqrt((ways**2).sum(axis=0))
        mask |= size <= radius
    for _ in range(draw(st.sampled_from([0, 0, 1, 5]))):
        mask[tuple(random.integers(0, shape))] = False
    return mask


def assert_equal_to_all_sizes(nodes, mask):
    sizes = cube_sizes(mask)
    edge = int(sizes.max())
    assert largest_cube(nodes) == edge
    for one in {max(edge, 1), max(edge - 1, 1), (edge + 1) // 2 or 1}:
        np.testing.assert_array_equal(cube_ends(nodes, one), np.argwhere(sizes >= one))


class TestMask:
    @settings(max_examples=200, deadline=None)
    @given(solids())
    def test_agrees_with_all_sizes_on_solids(self, mask):
        assert_equal_to_all_sizes(mask, mask)

    def test_a_hole_that_a_coarse_look_misses_counts(self):
        mask = np.ones((61, 61, 61), dtype=bool)
        mask[30, 29, 31] = False
        assert largest_cube(mask) == 31
        assert_equal_to_all_sizes(mask, mask)

    def test_what_a_coarse_look_takes_for_solid_may_be_stripes(self):
        for axis in range(2):
            mask = np.zeros((61, 61, 61), dtype=bool)
            mask[(slice(None),) * axis + (slice(None, None, 4),)] = True
            assert largest_cube(mask) == 1

    @settings(max_examples=500, deadline=None)
    @given(masks())
    def test_equals_twin_on_noise(self, mask):
        assert_equal_to_the_twin(mask, mask)

    @settings(max_examples=150, deadline=None)
    @given(masks(st.permutations([3, 4, 70])))
    def test_equals_twin_on_slabs_along_each_axis(self, mask):
        assert_equal_to_the_twin(mask, mask)

    @pytest.mark.parametrize("row", [1, 2, 31, 63, 64, 65, 127, 128, 129, 192, 256])
    @pytest.mark.parametrize("density", [0.9, 1.0])
    def test_equals_twin_on_rows_about_the_length_of_words(self, row, density):
        mask = np.random.default_rng(row).random((5, 4, row)) < density
        assert_equal_to_the_twin(mask, mask)
        assert_equal_to_the_twin(mask[:, 0], mask[:, 0])

    def test_equals_twin_on_a_ball(self):
        x, y, z = np.ogrid[-1:1:40j, -1:1:45j, -1:1:70j]
        mask = x**2 + y**2 + z**2 <= 0.9
        assert_equal_to_the_twin(mask, mask)

    @pytest.mark.parametrize("shape", [(257, 258, 260), (256, 320)])
    def test_of_a_full_mask_fills_its_least_extent_also_over_255_nodes(self, shape):
        mask = np.ones(shape, dtype=bool)
        assert largest_cube(mask) == min(shape)
        room = [range(min(shape) - 1, extent) for extent in shape]
        expected = np.stack(np.meshgrid(*room, indexing="ij"), axis=-1).reshape(-1, len(shape))
        np.testing.assert_array_equal(cube_ends(mask, min(shape)), expected)

    def test_agrees_with_all_sizes_where_a_hole_breaks_a_cube_of_over_255_nodes(self):
        mask = np.ones((260, 260, 330), dtype=bool)
        mask[130, 128, 64] = False
        sizes = cube_sizes(mask)
        assert largest_cube(mask) == sizes.max()
        np.testing.assert_array_equal(cube_ends(mask, 258), np.argwhere(sizes >= 258))

    @pytest.mark.parametrize("shape", [(0, 3, 4), (3, 0, 4), (3, 4, 0), (0, 0, 0), (0, 4), (4, 0)])
    def test_without_nodes_has_none(self, shape):
        assert largest_cube(np.zeros(shape, dtype=bool)) == 0

    def test_counts_every_nonzero_node_of_any_layout(self):
        mask = np.random.default_rng(1).integers(0, 9, (12, 10, 140), dtype=np.uint8)
        view = mask.T[::2, ::-1]
        assert_equal_to_the_twin(mask, mask)
        assert_equal_to_the_twin(view, view)


class TestWithin:
    @settings(max_examples=300, deadline=None)
    @given(masks(), seeds)
    def test_one_value_a_node_equals_twin(self, mask, seed):
        assert_equal_to_the_twin(Within(field_of(mask, seed), mask.shape, 0.0, 1.0), mask)

    @settings(max_examples=300, deadline=None)
    @given(masks(), seeds)
    def test_least_and_greatest_equal_twin(self, mask, seed):
        assert_equal_to_the_twin(Within(two_sided(mask, seed), mask.shape, 0.0, 1.0), mask)

    @pytest.mark.parametrize("row", [63, 64, 65, 1023, 1024, 1025, 1100])
    @pytest.mark.parametrize("of_mask", [field_of, two_sided])
    def test_equals_twin_on_rows_about_the_length_of_words_and_blocks(self, row, of_mask):
        mask = np.random.default_rng(row).random((4, 3, row)) < 0.95
        assert_equal_to_the_twin(Within(of_mask(mask), mask.shape, 0.0, 1.0), mask)

    @settings(max_examples=30, deadline=None)
    @given(solids(), seeds)
    def test_agrees_with_all_sizes_on_solids(self, mask, seed):
        assert_equal_to_all_sizes(Within(field_of(mask, seed), mask.shape, 0.0, 1.0), mask)

    def test_of_strided_fields_is_that_of_their_copies(self):
        mask = np.random.default_rng(2).random((7, 8, 70)) < 0.95
        wide = np.repeat(two_sided(mask), 3, axis=1)[::-1]
        assert_equal_to_the_twin(Within(wide[:, ::3], mask.shape, 0.0, 1.0), mask[::-1, ::-1, ::-1])

    @pytest.mark.parametrize("columns", [(), (2,)])
    def test_nothing_is_out_of_no_bounds_but_nan(self, columns):
        field = np.random.default_rng(3).choice([-np.inf, 0.0, np.inf], (60, *columns))
        assert largest_cube(Within(field, (3, 4, 5))) == 3
        field[:] = np.nan
        assert largest_cube(Within(field, (3, 4, 5))) == 0


NODES = np.ones((2, 3, 4), dtype=np.uint8)
LOW = np.ones((2, 3, 4))


def words(*shape):
    return np.zeros(shape, dtype=np.uint64)


class TestArguments:
    @pytest.mark.parametrize(
        ("nodes", "axes", "exception", "message"),
        [
            ((), 3, TypeError, "nodes are"),
            ((LOW, LOW), 3, TypeError, "nodes are"),
            ((NODES, LOW, 0.0, 1.0), 3, TypeError, "low has the wrong type"),
            ((LOW,), 3, TypeError, "mask has the wrong type"),
            ((NODES[0],), 3, ValueError, "mask has the wrong number"),
            ((NODES.T,), 3, ValueError, "mask is not C-contiguous"),
            ((NODES,), 2, ValueError, "axes is neither"),
            ((NODES,), 4, ValueError, "axes is neither"),
            ((LOW, NODES, 0.0, 1.0), 3, TypeError, "high has the wrong type"),
            ((LOW, LOW[:1], 0.0, 1.0), 3, ValueError, "high has another shape"),
            ((LOW, np.ones((4, 3, 2)).T, 0.0, 1.0), 3, ValueError, "high has other strides"),
        ],
    )
    def test_wrong_nodes_are_named(self, nodes, axes, exception, message):
        with pytest.raises(exception, match=message):
            _kernels.largest_cube(nodes, axes)
        with pytest.raises(exception, match=message):
            _kernels.cube_ends(nodes, axes, 1, words(2, 3, 1))

    @pytest.mark.parametrize(
        ("edge", "out", "exception", "message"),
        [
            (0, words(2, 3, 1), ValueError, "edge is not that of a cube"),
            (3, words(2, 3, 1), ValueError, "edge is not that of a cube"),
            (1, words(2, 3, 2), ValueError, "out has another shape"),
            (1, words(2, 3, 1).astype(float), TypeError, "out has the wrong type"),
            (1, words(2, 3), ValueError, "out has the wrong number"),
        ],
    )
    def test_wrong_ends_are_named(self, edge, out, exception, message):
        with pytest.raises(exception, match=message):
            _kernels.cube_ends((NODES,), 3, edge, out)

    def test_ends_over_the_nodes_are_refused(self):
        shared = words(2, 3, 1)
        with pytest.raises(ValueError, match="out overlaps the nodes"):
            _kernels.cube_ends((shared.view(np.float64), shared.view(np.float64), 0.0, 1.0), 3, 1, shared)

    def test_a_field_of_another_length_than_the_grid_is_refused(self):
        with pytest.raises(ValueError, match="reshape"):
            largest_cube(Within(np.zeros(7), (2, 2, 2)))
