import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.trajectory import Array

START = np.zeros((1, 1))
TIME = np.linspace(-1.0, 1.0, 4001)[None, None]


def ramp(time: Array) -> Array:
    return (0.3 * time)[..., None]


def test_readings_lie_on_the_lattice_within_half_a_step() -> None:
    model, steps = block().with_effect(placed(block(), "quantisation", "rail")), np.array([[0.0], [0.01], [0.05]])
    seen = model.reading(steps, "rail.position", ramp, START)(TIME)[:, 0, :, 0]
    exact = 0.3 * TIME[0, 0]
    np.testing.assert_array_equal(seen[0], exact)
    for (step,), row in zip(steps[1:], seen[1:], strict=True):
        np.testing.assert_allclose(row / step, np.rint(row / step), atol=1e-12)
        assert np.abs(row - exact).max() <= step / 2 + 1e-12
        assert np.std(row - exact) == pytest.approx(step / np.sqrt(12.0), rel=0.01)
    for channel in ("rail.velocity", "other.position"):
        assert model.reading(steps, channel, ramp, START) is ramp


def test_fits_start_away_from_absent() -> None:
    one = placed(block(), "quantisation", "rail")
    assert [start["quantisation@rail.step"] for start in one.starts] == pytest.approx([0.005, 0.02])
    assert one.parameters[0].high == pytest.approx(0.05)
