"""Effects that all actuators of a machine share."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from effect_machines import catalogue_effect, placed, scales_of
from own_robot import MJCF

from dr_lab.effects.command_filter import DynamicDriver
from dr_lab.envs.drivers import stepwise
from dr_lab.errors import UnknownNameError
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

ALIKE = '<motor name="one" joint="shoulder"/><motor name="two" joint="elbow" gear="-1"/>'
UNLIKE = '<motor name="one" joint="shoulder"/><motor name="two" joint="elbow" gear="3"/>'
SERVOS = '<position name="one" joint="shoulder" kp="5" kv="1"/><position name="two" joint="elbow" kp="9" kv="1"/>'
COMMANDS = np.stack([3.0 * np.sin(0.1 * np.arange(150)), np.where(np.arange(150) % 50 < 25, 2.0, -1.0)], axis=-1)
VALUES = {
    "actuator_delay": {"delay": 0.0171},
    "actuator_lag": {"tau": 0.009},
    "command_power": {"exponent": 1.7, "full": 4.0},
    "dead_zone": {"width": 0.6},
    "rate_limit": {"inverse_rate": 0.01},
    "saturation": {"inverse_limit": 0.6},
    "torque_scale": {"factor": 0.8},
    "coasting_bridge": {"inverse_speed": 0.05},
    "torque_speed_limit": {"inverse_stall": 0.5, "inverse_speed": 0.05},
    "voltage_sag": {"slope": 0.1},
}


def arm(actuators: str) -> Model:
    """Two links that hang, with these actuators."""
    xml = re.sub("<actuator>.*</actuator>", f"<actuator>{actuators}</actuator>", MJCF)
    return from_spec("two", mujoco.MjSpec.from_string(xml), {})


def positions(model: Model, values: dict[str, float]) -> Array:
    """Joint positions under `COMMANDS`, from rest, shape (steps + 1, 2)."""
    z, past = model.space.vector(values)[None], np.zeros((1, 40, 2))
    return (
        Simulator(model, 1, threads=1).replay(z, np.zeros((1, 1, 2)), np.zeros((1, 1, 2)), COMMANDS[None], past).qpos[0]
    )


def holding(model: Model, name: str, sites: tuple[str, ...]) -> tuple[Model, dict[str, float]]:
    """A model with an effect at sites, and the same values of it at each."""
    values: dict[str, float] = {}
    for site in sites:
        model = model.with_effect(placed(model, name, site))
        values |= {f"{name}@{site}.{key}": value for key, value in VALUES[name].items()}
    return model, values


@pytest.mark.parametrize("name", VALUES)
def test_acts_as_the_same_effect_at_each_of_them(name: str) -> None:
    together, apart = (holding(arm(ALIKE), name, sites) for sites in (("all_actuators",), ("one", "two")))
    assert len(together[1]) == len(VALUES[name])
    moved = positions(*together)
    np.testing.assert_allclose(moved, positions(*apart), atol=1e-12)
    assert np.abs(moved - positions(arm(ALIKE), {})).max() > 1e-3


def test_acts_at_each_of_them_under_a_policy() -> None:
    together, apart = (holding(arm(ALIKE), "actuator_lag", sites) for sites in (("all_actuators",), ("one", "two")))
    laws = [stepwise(m).laws(m.space.vector(v)[None], [m.nominal()]) for m, v in (together, apart)]
    columns = [[law.column for law in each if isinstance(law, DynamicDriver)] for each in laws]
    assert columns == [[0, 1], [0, 1]]


def test_delays_of_all_and_of_one_add_up() -> None:
    both = arm(ALIKE)
    for site in ("all_actuators", "two"):
        both = both.with_effect(placed(both, "actuator_delay", site))
    apart, _ = holding(arm(ALIKE), "actuator_delay", ("one", "two"))
    summed = positions(both, {"actuator_delay@all_actuators.delay": 0.012, "actuator_delay@two.delay": 0.009})
    expected = positions(apart, {"actuator_delay@one.delay": 0.012, "actuator_delay@two.delay": 0.021})
    np.testing.assert_allclose(summed, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("actuators", "name", "shared"),
    [
        (ALIKE, "actuator_lag", True),
        (ALIKE, "dead_zone", True),
        (UNLIKE, "actuator_lag", True),  # a time
        (UNLIKE, "torque_scale", True),  # a factor
        (UNLIKE, "dead_zone", False),  # N·m of drives of other sizes
        (SERVOS, "gain_error", True),
        (SERVOS, "force_limit", False),  # N·m of servos that pull with other gains
        (ALIKE, "force_limit", False),  # of a motor it is a saturation
        (SERVOS, "command_power", False),  # no site at all
        ('<motor name="one" joint="shoulder"/>', "actuator_lag", False),
    ],
)
def test_drives_share_what_means_the_same_to_them(actuators: str, name: str, *, shared: bool) -> None:
    assert ("all_actuators" in catalogue_effect(name).sites(arm(actuators).nominal())) == shared


def test_an_actuator_of_that_name_comes_first() -> None:
    model = arm('<motor name="one" joint="shoulder"/><motor name="all_actuators" joint="elbow"/>')
    one = placed(model, "actuator_lag", "all_actuators")
    assert one.elements == ("all_actuators",)
    assert one.effect.sites(model.nominal()) == ("one", "all_actuators")


def test_bounds_are_those_of_the_drive_that_is_used_most() -> None:
    model = arm(ALIKE)
    scales = replace(scales_of(model), command={"one": 1.0, "two": 5.0})
    shared, one, two = (placed(model, "dead_zone", site, scales) for site in ("all_actuators", "one", "two"))
    assert shared.parameters[0].high == two.parameters[0].high > one.parameters[0].high


def test_a_name_that_is_none_is_told_what_there_is() -> None:
    with pytest.raises(UnknownNameError, match="all_actuators"):
        placed(arm(ALIKE), "dead_zone", "three")
