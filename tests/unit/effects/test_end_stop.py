"""A block that turns back at a stop."""

from dataclasses import replace

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, motion, placed, scales_of, with_effect

from dr_lab.effects.named import with_named_effects
from dr_lab.errors import ModelError


def test_a_block_turns_back_at_the_stop_and_goes_on_without_one() -> None:
    stopped = motion(with_effect(block(), "end_stop", "rail", upper=0.1), 0.5, qvel=1.0)
    assert stopped[:, 1].max() == pytest.approx(0.1, abs=0.01)
    assert stopped[-1, 2] < 0
    free = motion(with_effect(block(), "end_stop", "rail"), 0.5, qvel=1.0)
    np.testing.assert_allclose(free[:, 1], free[:, 0], atol=1e-12)


@pytest.mark.parametrize(("ratio", "constant"), [(0.1, 0.02), (0.3, 0.05)])
def test_a_soft_stop_gives_way_and_throws_back_what_its_damping_leaves(ratio: float, constant: float) -> None:
    """A spring and a damper that only push: Schwager and Pöschel, Granular Matter 9 (2007) 465."""
    values = {"upper": 0.1, "time_constant": constant, "damping_ratio": ratio}
    stopped = motion(with_effect(block(), "end_stop", "rail", **values), 0.5, qvel=1.0)
    damped = np.sqrt(1 - ratio**2)
    swing = np.pi - np.arctan(2 * ratio * damped / (1 - 2 * ratio**2))
    assert stopped[-1, 2] == pytest.approx(-np.exp(-ratio / damped * swing), rel=0.03)
    deepest = constant * np.exp(-ratio / damped * np.arctan(damped / ratio))
    assert stopped[:, 1].max() - 0.1 == pytest.approx(deepest, rel=0.03)


def test_what_a_joint_without_a_limit_says_of_one_means_nothing() -> None:
    undamped = with_effect(block(joint='solreflimit="-1000 0"'), "end_stop", "rail", upper=0.1)
    plain = with_effect(block(), "end_stop", "rail", upper=0.1)
    np.testing.assert_array_equal(motion(undamped, 0.5, qvel=1.0), motion(plain, 0.5, qvel=1.0))


def test_stops_begin_outside_the_travel_and_start_inside() -> None:
    effect = placed(block(), "end_stop", "rail", scales_of(block(), position=2.0))
    upper, lower, constant, ratio = effect.parameters
    assert upper.nominal == upper.high >= 3.0  # a log that goes twice as far meets no stop
    assert lower.nominal == lower.low <= -3.0
    assert (constant.nominal, ratio.nominal) == (0.02, 1.0)  # MuJoCo's own
    assert constant.low <= constant.nominal < constant.high
    assert all(start["end_stop@rail.lower"] > -1.0 or start["end_stop@rail.upper"] < 1.0 for start in effect.starts)


def test_stops_of_a_machine_of_which_nothing_is_known_are_absent_until_they_are_named() -> None:
    found = with_named_effects(block(), {"end_stop": catalogue_effect("end_stop")}, ["end_stop@rail.upper"])
    free = motion(found.nominal(), 0.5, qvel=1.0)
    np.testing.assert_allclose(free[:, 1], free[:, 0], atol=1e-12)
    stopped = motion(found.compile(found.space.vector({"end_stop@rail.upper": 0.1})), 0.5, qvel=1.0)
    assert stopped[:, 1].max() == pytest.approx(0.1, abs=0.01)


def test_a_joint_that_rests_shows_no_stop() -> None:
    with pytest.raises(ModelError, match="measured and moves"):
        placed(block(), "end_stop", "rail", scales_of(block(), position=0.0))
    with pytest.raises(ModelError, match="measured and moves"):
        placed(block(), "end_stop", "rail", replace(scales_of(block()), unmeasured=frozenset({"rail"})))
