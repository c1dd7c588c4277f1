import numpy as np

from dr_lab.training.history import adapted_returns, curves


def test_a_figure_is_a_line_through_the_iterations_that_know_it() -> None:
    rows = [
        {"iteration": 1.0, "loss": 3.0},
        {"iteration": 2.0, "loss": np.nan, "round": 5.0},
        {"iteration": 3.0, "loss": 1.0},
    ]
    by_name = {curve.name: (curve.at.tolist(), curve.value.tolist()) for curve in curves(rows)}
    assert by_name == {"loss": ([1, 3], [3.0, 1.0]), "round": ([2], [5.0])}


def test_a_figure_that_is_never_known_is_no_curve() -> None:
    # The viewer panics at a line without any point.
    assert not curves([{"iteration": 1.0, "loss": np.nan}])


def test_returns_of_adapted_policies_are_means_over_the_last_iterations() -> None:
    rows = [{"return_after_0": -9.0, "return_after_1": -9.0}] * 8
    rows += [{"return_after_0": -4.0, "return_after_1": -2.0}, {"return_after_0": np.nan, "return_after_1": -1.0}]
    assert adapted_returns(rows, 0.2) == (-4.0, -1.5)
    assert adapted_returns([{"episode_return": 3.0}], 0.2) == ()


def test_returns_are_shown_first_even_if_no_episode_ends_at_first() -> None:
    rows = [{"kl": 0.1, "episode_return": np.nan} | {"iteration": 1.0}, {"iteration": 2.0, "episode_return": 3.0}]
    assert [curve.name for curve in curves(rows)] == ["episode_return", "kl"]


def test_what_an_adapted_policy_returns_is_shown_first() -> None:
    row = {"iteration": 1.0, "episode_return": 0.0, "return_after_0": -4.0, "return_after_1": -2.0, "kl": 0.1}
    assert [curve.name for curve in curves([row])] == ["return_after_1", "return_after_0", "kl"]


def test_infeasible_episodes_are_plotted_where_there_are_any() -> None:
    rows = [{"iteration": 1.0, "infeasible_episodes": 0.0, "kl": 0.1}, {"iteration": 2.0, "infeasible_episodes": 0.0}]
    assert [curve.name for curve in curves(rows)] == ["kl"]
    rows[1]["infeasible_episodes"] = 2.0
    assert [curve.name for curve in curves(rows)] == ["infeasible_episodes", "kl"]
