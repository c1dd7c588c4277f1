"""A shift in time below what the clock of simulation and commands resolves is told from none by nobody."""

import pytest
from effect_machines import placed

from dr_lab.diagnosis.search.candidate import resolved
from tests.diagnosis_machines import pendulum

LEAST = 0.004  # s


@pytest.mark.parametrize(
    ("name", "site", "parameter"),
    [
        ("actuator_delay", "drive", "delay"),
        ("actuator_lag", "drive", "tau"),
        ("sensor_time_offset", "hinge", "offset"),
        ("sensor_low_pass", "hinge", "tau"),
        ("velocity_low_pass", "hinge", "tau"),
    ],
)
@pytest.mark.parametrize(("share", "told"), [(0.0, False), (0.5, False), (0.99, False), (1.0, True), (2.0, True)])
def test_timing_effects_from_the_resolution_on(
    name: str, site: str, parameter: str, share: float, *, told: bool
) -> None:
    effect = placed(pendulum(), name, site)
    assert resolved(effect, {f"{effect.label}.{parameter}": share * LEAST}, LEAST) is told


def test_an_offset_to_the_other_side_counts_as_much() -> None:
    effect = placed(pendulum(), "sensor_time_offset", "hinge")
    assert not resolved(effect, {f"{effect.label}.offset": -0.5 * LEAST}, LEAST)  # half a sample, either way
    assert resolved(effect, {f"{effect.label}.offset": -1.5 * LEAST}, LEAST)


def test_what_is_no_shift_in_time_needs_no_resolution() -> None:
    effect = placed(pendulum(), "coulomb_friction", "hinge")
    assert resolved(effect, {f"{effect.label}.torque": 0.0}, LEAST)
