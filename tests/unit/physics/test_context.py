import numpy as np
import pytest

from dr_lab.errors import UnknownNameError
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.parameter import Parameter

SPACE = ContextSpace((Parameter("mass", "kg", 2.0, 1.0, 5.0), Parameter("friction", "N", 0.0, 0.0, 0.5)))


def test_unit_cube_is_the_bounds() -> None:
    np.testing.assert_allclose(SPACE.to_unit(SPACE.low), 0)
    np.testing.assert_allclose(SPACE.to_unit(SPACE.high), 1)
    z = np.array([[1.7, 0.2], [4.9, 0.01]])
    np.testing.assert_allclose(SPACE.from_unit(SPACE.to_unit(z)), z)


def test_names_and_vector_agree() -> None:
    z = SPACE.vector({"friction": 0.3})
    np.testing.assert_allclose(z, [2.0, 0.3])
    assert SPACE.mapping(z) == {"mass": 2.0, "friction": 0.3}
    with pytest.raises(UnknownNameError, match="Did you mean 'friction'"):
        SPACE.vector({"frictoin": 1.0})


def test_estimate_tells_standard_deviations() -> None:
    estimate = ContextEstimate(SPACE, np.array([2.1, 0.1]), np.diag([0.04, 1e-4]))
    assert estimate.table()["mass"] == {"value": 2.1, "std": pytest.approx(0.2), "unit": "kg"}


def test_a_value_far_above_a_small_bound_is_not_at_it() -> None:
    speed = Parameter("creep", "rad/s", 0.01, 0.0009031, 3.612)
    assert speed.touches(0.002273) == (False, False)
    assert speed.touches(0.000904) == (True, False)
    assert speed.touches(3.611) == (False, True)
    assert Parameter("fall", "m/s", -0.01, -3.612, -0.0009031).touches(-0.002273) == (False, False)
    assert Parameter("torque", "N", 0.0, 0.0, 2.0).touches(0.001) == (True, False)
