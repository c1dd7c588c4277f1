import numpy as np
import pytest

from dr_lab.trajectory import Signal


@pytest.mark.parametrize(("time", "wait"), [([0.0, 0.1, 0.2, 5.0], 0.1), ([1.0, 1.5], 0.5), ([3.0], 0.0), ([], 0.0)])
def test_the_usual_time_between_two_samples_is_that_of_most(time: list[float], wait: float) -> None:
    signal = Signal("drive", "N·m", np.array(time), np.zeros(len(time)))
    assert signal.wait == pytest.approx(wait)
