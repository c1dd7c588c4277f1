import numpy as np
from effect_machines import block, placed

SLOPES = np.array([[0.0], [0.04], [0.1]])


def test_commands_lose_in_proportion_to_their_square() -> None:
    model = block().with_effect(placed(block(), "voltage_sag", "drive"))
    series = np.array([[[-5.0, -2.0, 0.0, 1.0, 5.0]]])
    expected = [[-5, -2, 0, 1, 5], [-4, -1.84, 0, 0.96, 4], [-2.5, -1.6, 0, 0.9, 2.5]]
    np.testing.assert_allclose(model.command(SLOPES, "drive", series)[:, 0], expected)
    assert model.command(SLOPES, "another", series) is series


def test_larger_commands_stay_larger_up_to_the_bound() -> None:
    one = placed(block(), "voltage_sag", "drive")
    (parameter,) = one.parameters
    assert parameter.high == 0.5 / 5.0
    series = np.linspace(-5.0, 5.0, 101)[None, None]
    assert (np.diff(block().with_effect(one).command(np.array([[0.1]]), "drive", series)) > 0).all()
