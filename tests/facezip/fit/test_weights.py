import numpy as np
import pytest

from facezip.fit.weights import RIDGE, Moves, WeightSystem, improve_weights, solve_weights


def random_system(h=4, w=5, slots=2, count=3, seed=0):
    """A positive definite system on a grid, and the same as a dense matrix."""
    random = np.random.default_rng(seed)
    system = WeightSystem.zeros((h, slots, count, w))
    dense = np.zeros((h, w, slots, h, w, slots))
    for y in range(h):
        for x in range(w):
            for q in range(9):
                ny, nx = y + q // 3 - 1, x + q % 3 - 1
                if 0 <= ny < h and 0 <= nx < w and (ny, nx) >= (y, x):
                    block = random.normal(size=(slots, slots)) * 0.3
                    block = block + block.T + 6 * np.eye(slots) if (ny, nx) == (y, x) else block
                    dense[y, x, :, ny, nx] = block
                    dense[ny, nx, :, y, x] = block.T
                    system.matrix[y, :, :, q, x] = block
                    system.matrix[ny, :, :, 8 - q, nx] = block.T
    system.right[:] = random.normal(size=system.right.shape)
    return system, dense.reshape(h * w * slots, -1)


def product(matrix, weights):
    """A·x of couplings ``(h, R, R, 9, w)`` and weights ``(h, R, N, w)``."""
    h, _, _, w = weights.shape
    near = np.pad(weights.astype(float), ((1, 1), (0, 0), (0, 0), (1, 1)))
    cells = (near[q // 3 : q // 3 + h, :, :, q % 3 : q % 3 + w] for q in range(9))
    return sum(np.einsum("hijw,hjnw->hinw", matrix[:, :, :, q], cell) for q, cell in enumerate(cells))


def flat(weights):
    return weights.transpose(0, 3, 1, 2).reshape(-1, weights.shape[2]).astype(float)


def test_conjugate_gradients_reach_the_dense_solution():
    system, dense = random_system()
    weights = np.zeros_like(system.right)
    for _ in range(20):
        weights = solve_weights(system, weights)
    np.testing.assert_allclose(flat(weights), np.linalg.solve(dense, flat(system.right)), atol=1e-4)


@pytest.mark.parametrize(("h", "w"), [(4, 5), (20, 40)])
def test_every_call_lowers_the_error(h, w):
    system, dense = random_system(h, w)
    weights, right = np.zeros_like(system.right), flat(system.right)
    explained = []
    for _ in range(4):
        weights = solve_weights(system, weights)
        x = flat(weights)
        explained.append(float((2 * x * right - x * (dense @ x)).sum()))
    # Once it is solved to single precision, rounding is all that moves.
    assert np.diff(explained).min() > -1e-6 * max(explained)


def test_only_what_moves_is_solved_beside_what_stays():
    """Against the dense system of the texels that move, with what the others contribute on its right side."""
    system, dense = random_system(h=20, w=24)
    moving = np.random.default_rng(1).random((20, 24)) < 0.4
    start = np.random.default_rng(2).normal(size=system.right.shape).astype(np.float32)
    weights, free = start.copy(), np.repeat(moving.ravel(), 2)
    for _ in range(20):
        improve_weights(system, weights, Moves.of(moving, start))
    stays = np.broadcast_to(~moving[:, None, None], start.shape)
    np.testing.assert_array_equal(weights[stays], start[stays])
    rest = flat(system.right)[free] - dense[np.ix_(free, ~free)] @ flat(start)[~free]
    np.testing.assert_allclose(flat(weights)[free], np.linalg.solve(dense[np.ix_(free, free)], rest), atol=1e-4)


def test_gains_and_the_way_are_those_of_each_texels_own_equations():
    system, dense = random_system(h=9, w=18)
    random = np.random.default_rng(3)
    before, start = random.normal(size=(2, *system.right.shape)).astype(np.float32)
    moves, rest = Moves.of(np.ones((9, 18), bool), before), flat(system.right) - dense @ flat(start)
    # One window alone begins where the start is: the first.
    improve_weights(system, start.copy(), moves)
    for texel in (0, 3, 18 + 5):
        own = slice(2 * texel, 2 * texel + 2)
        gain = (rest[own] * np.linalg.solve(dense[own, own], rest[own])).sum()
        way = (rest[own] * (flat(start) - flat(before))[own]).sum()
        assert moves.gains.flat[texel] == pytest.approx(gain, rel=1e-4)
        assert moves.along.flat[texel] == pytest.approx(way, rel=1e-3, abs=1e-3)


def test_ties_are_those_of_a_grid_with_its_neighbours():
    system, h, w = WeightSystem.zeros((3, 2, 1, 4)), 3, 4
    system.regularise(2.0, smoothness=0.5)
    for y in range(h):
        for x in range(w):
            row = np.zeros((3, 3))
            for ny, nx in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                if 0 <= ny < h and 0 <= nx < w:
                    row[ny - y + 1, nx - x + 1] = -1
            row[1, 1] = -row.sum() + RIDGE * 2
            np.testing.assert_allclose(system.matrix[y, 0, 0, :, x], row.ravel(), rtol=1e-6)
            np.testing.assert_array_equal(system.matrix[y, 0, 0], system.matrix[y, 1, 1])
    assert not system.matrix[:, 0, 1].any()


def test_the_start_is_not_changed():
    system, _ = random_system()
    start = np.ones_like(system.right)
    solve_weights(system, start)
    assert (start == 1).all()


def test_smoothness_spreads_weights_to_texels_that_nothing_sees():
    system = WeightSystem.zeros((5, 1, 1, 5))
    system.matrix[2, 0, 0, 4, 2], system.right[2, 0, 0, 2] = 1, 3
    weights = np.zeros_like(system.right)
    system.regularise(1e-3)
    for _ in range(30):
        weights = solve_weights(system, weights)
    assert weights[2, 0, 0, 2] == pytest.approx(3, rel=1e-3)
    assert 3 > weights[2, 0, 0, 1] > weights[2, 0, 0, 0] > 0


@pytest.mark.parametrize("shape", [(1, 2, 3, 1), (1, 1, 2, 6), (40, 2, 3, 1)])
def test_grids_of_a_single_row_or_column(shape):
    system = WeightSystem.zeros(shape)
    slots = np.arange(shape[1])
    system.matrix[:, slots, slots, 4] = 2
    system.right[:] = 1
    weights = solve_weights(system, np.zeros(shape, np.float32))
    np.testing.assert_allclose(weights, 0.5, atol=1e-6)
