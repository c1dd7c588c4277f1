import numpy as np
import pytest
from scipy.integrate import quad

from dr_lab.diagnosis.windows.commands import averages
from dr_lab.trajectory import Signal


def test_a_step_inside_a_substep_enters_as_its_time_average() -> None:
    signal = Signal("motor", "V", np.array([0.0, 0.013]), np.array([2.0, -4.0]))
    edges = np.array([[0.0, 0.01, 0.02, 0.03]])
    np.testing.assert_allclose(averages({"motor": signal}, {"motor": 0}, 1, edges)[0, :, 0], [2.0, -2.2, -4.0])


def test_averages_are_integrals_of_the_held_signal() -> None:
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.001, 0.009, 60))
    signal = Signal("motor", "V", time, rng.normal(size=60))
    edges = np.linspace(time[0] - 0.02, time[-1] + 0.02, 40)[None]

    def held(t: float) -> float:
        return float(signal.value[max(np.searchsorted(time, t, side="right") - 1, 0)])

    found = averages({"motor": signal}, {"motor": 1}, 2, edges)
    for k in range(39):
        a, b = edges[0, k], edges[0, k + 1]
        inside = time[(time > a) & (time < b)]
        expected = quad(held, a, b, points=inside if len(inside) else None, limit=200)[0] / (b - a)
        assert found[0, k, 1] == pytest.approx(expected, abs=1e-9)
    assert not found[0, :, 0].any()
