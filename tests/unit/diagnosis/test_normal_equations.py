import numpy as np

from dr_lab.diagnosis.fit.identifiability import identifiability
from dr_lab.diagnosis.fit.normal_equations import NormalEquations, inverse_root, within
from dr_lab.diagnosis.fit.solved import solved

W, M, S, P = 4, 30, 2, 3


def problem(seed: int = 0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        "residual": rng.normal(size=(W, M)),
        "state_jacobian": rng.normal(size=(W, M, S)),
        "parameter_jacobian": rng.normal(size=(W, M, P)),
        "weight": rng.uniform(0.2, 1.0, (W, M)),
        "delta": rng.normal(size=(W, S)),
        "state_precision": np.array([2.0, 0.5]),
        "prior": np.array([0.1, 0.2, 0.3]),
        "prior_gradient": rng.normal(size=P),
    }


def dense(p: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Hessian and gradient over all unknowns at once, states first."""
    n = W * S + P
    hessian, gradient = np.zeros((n, n)), np.zeros(n)
    for w in range(W):
        jacobian = np.zeros((M, n))
        jacobian[:, w * S : (w + 1) * S] = p["state_jacobian"][w]
        jacobian[:, W * S :] = p["parameter_jacobian"][w]
        hessian += jacobian.T * p["weight"][w] @ jacobian
        gradient += jacobian.T @ (p["weight"][w] * p["residual"][w])
    precision = np.concatenate([np.tile(p["state_precision"], W), p["prior"]])
    gradient[: W * S] += (p["state_precision"] * p["delta"]).ravel()
    gradient[W * S :] += p["prior_gradient"]
    return hessian + np.diag(precision), gradient


def test_the_eliminated_step_is_the_dense_one() -> None:
    p = problem()
    hessian, gradient = dense(p)
    expected = -np.linalg.solve(hessian, gradient)
    move, states = NormalEquations.build(**p).step(0.0, np.ones(P, bool))
    np.testing.assert_allclose(move, expected[W * S :])
    np.testing.assert_allclose(states.ravel(), expected[: W * S])


def test_states_of_an_unstable_simulation_have_a_solution() -> None:
    """Two states move the end alike, and so far that their prior is less than rounding beside it."""
    equations = np.full((1, 2, 2), 1e18) + np.eye(2)
    right = np.full((1, 2, 1), 1e18)
    np.testing.assert_allclose(equations @ solved(equations, right), right, rtol=1e-6)


def test_a_parameter_of_which_rounding_leaves_less_than_nothing_stays_within_its_room() -> None:
    information = np.diag([1e12, -1e-6])
    move = within(np.array([5.0, 5.0]), information, np.ones(2), np.ones(2, bool), (np.full(2, -0.1), np.full(2, 0.1)))
    assert np.isfinite(move).all()
    assert (np.abs(move) <= 0.1).all()


def test_a_held_parameter_does_not_move_and_the_others_adapt() -> None:
    p = problem()
    hessian, gradient = dense(p)
    kept = np.delete(np.arange(W * S + P), W * S + 1)
    expected = -np.linalg.solve(hessian[np.ix_(kept, kept)], gradient[kept])
    move, _ = NormalEquations.build(**p).step(0.0, np.array([True, False, True]))
    assert move[1] == 0
    np.testing.assert_allclose(move[[0, 2]], expected[W * S :])


def test_the_predicted_decrease_is_that_of_the_dense_quadratic() -> None:
    p = problem()
    hessian, gradient = dense(p)
    equations = NormalEquations.build(**p)
    for free in (np.ones(P, bool), np.array([True, False, True]), np.zeros(P, bool)):
        kept = np.concatenate([np.ones(W * S, bool), free])
        expected = gradient[kept] @ np.linalg.solve(hessian[np.ix_(kept, kept)], gradient[kept])
        np.testing.assert_allclose(equations.decrease(free), expected)
        np.testing.assert_allclose(equations.full_step(free).windows, window_decreases(p, free))


def test_what_is_foretold_of_any_step_is_what_the_dense_quadratic_says() -> None:
    p, rng = problem(), np.random.default_rng(1)
    hessian, gradient = dense(p)
    equations = NormalEquations.build(**p)
    step = rng.normal(size=W * S + P)
    expected = -(2 * gradient @ step + step @ hessian @ step)
    np.testing.assert_allclose(equations.foretold(step[W * S :], step[: W * S].reshape(W, S)), expected)
    full = equations.step(0.0, np.ones(P, bool))
    np.testing.assert_allclose(equations.foretold(*full), equations.decrease(np.ones(P, bool)))


def window_decreases(p: dict[str, np.ndarray], free: np.ndarray) -> list[float]:
    """Of each window's own cost, its state's prior included, by the dense step."""
    hessian, gradient = dense(p)
    kept, step = np.concatenate([np.ones(W * S, bool), free]), np.zeros(W * S + P)
    step[kept] = -np.linalg.solve(hessian[np.ix_(kept, kept)], gradient[kept])
    found = []
    for w in range(W):
        state = step[w * S : (w + 1) * S]
        change = p["state_jacobian"][w] @ state + p["parameter_jacobian"][w] @ step[W * S :]
        costs = [
            (p["weight"][w] * (p["residual"][w] + share * change) ** 2).sum()
            + (p["state_precision"] * (p["delta"][w] + share * state) ** 2).sum()
            for share in (0.0, 1.0)
        ]
        found.append(costs[0] - costs[1])
    return found


def test_parameters_that_replace_one_another_are_left_to_the_prior() -> None:
    """Of x + y the data know everything, of x − y nothing."""
    information, prior = 1e20 * np.ones((2, 2)), np.array([4.0, 1.0])
    root = inverse_root(information, prior)
    covariance = root @ root.T
    # with x = −y the prior's precision is that of both
    np.testing.assert_allclose(covariance, np.array([[1.0, -1.0], [-1.0, 1.0]]) / prior.sum(), rtol=1e-6)


def test_the_root_is_that_of_the_inverse() -> None:
    rng = np.random.default_rng(3)
    jacobian, prior = rng.normal(size=(5, 8, 3)), np.array([0.1, 2.0, 7.0])
    information = jacobian.transpose(0, 2, 1) @ jacobian
    root = inverse_root(information, prior)
    np.testing.assert_allclose(root @ root.transpose(0, 2, 1), np.linalg.inv(information + np.diag(prior)))


def test_information_is_the_inverse_of_the_dense_covariance() -> None:
    p = problem()
    covariance = np.linalg.inv(dense(p)[0])[W * S :, W * S :]
    built = NormalEquations.build(**p)
    np.testing.assert_allclose(built.reduced.information + np.diag(built.prior), np.linalg.inv(covariance))


def test_an_effect_that_a_parameter_can_replace_is_absorbed() -> None:
    p = problem()
    p["parameter_jacobian"][..., 2] = 3.0 * p["parameter_jacobian"][..., 0]
    p["prior"] = np.full(P, 1e-9)
    known = identifiability(NormalEquations.build(**p), 1)
    assert known.alone > 100
    assert known.share < 1e-6
    assert identifiability(NormalEquations.build(**problem()), 1).share > 0.5


def test_a_step_that_would_leave_the_bounds_is_the_best_within_them() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        root, gradient = rng.normal(size=(6, 6)), rng.normal(size=6)
        information, free = root @ root.T + 0.01 * np.eye(6), np.ones(6, bool)
        low, high = -rng.uniform(0, 0.3, 6), rng.uniform(0, 0.3, 6)
        unbounded = np.asarray(-np.linalg.solve(information, gradient), np.float64)
        move = within(unbounded, information, gradient, free, (low, high))
        slope = gradient + information @ move
        assert ((move >= low) & (move <= high)).all()
        inside = (move > low + 1e-9) & (move < high - 1e-9)
        np.testing.assert_allclose(slope[inside], 0.0, atol=1e-8)  # what may move both ways has no slope left
        assert (slope[move <= low + 1e-9] >= -1e-8).all()
        assert (slope[move >= high - 1e-9] <= 1e-8).all()


def test_only_what_is_free_and_has_room_moves() -> None:
    information, gradient = np.diag([1.0, 2.0, 3.0]), np.array([1.0, 1.0, 1.0])
    free = np.array([True, False, True])
    unbounded = np.array([-1.0, -1 / 3])
    np.testing.assert_array_equal(within(unbounded, information, gradient, free, None), [-1.0, 0.0, -1 / 3])
    room = (np.array([-0.2, -1.0, 0.0]), np.array([0.2, 1.0, 0.0]))
    np.testing.assert_allclose(within(unbounded, information, gradient, free, room), [-0.2, 0.0, 0.0], atol=1e-11)


def test_the_foretold_decrease_is_that_of_the_step_within_the_bounds() -> None:
    equations, free = NormalEquations.build(**problem()), np.ones(P, bool)
    unlimited = equations.decrease(free)
    assert equations.decrease(free, (np.full(P, -99.0), np.full(P, 99.0))) == unlimited
    nothing = equations.decrease(free, (np.zeros(P), np.zeros(P)))
    some = equations.decrease(free, (np.full(P, -0.05), np.full(P, 0.05)))
    assert nothing < some < unlimited
    assert nothing == equations.decrease(np.zeros(P, bool))
