"""Units by name, and the factor 57.3."""

import numpy as np
import pytest

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.signal_map import ChannelMap, channel_map
from dr_lab.measurements.unit_check import check_units
from dr_lab.measurements.units import unit
from dr_lab.trajectory import Array, Note, Signal

TIME = np.linspace(0.0, 6.0, 3001)
ANGLE = 1.2 * np.cos(7 * TIME)
SPEED = -8.4 * np.sin(7 * TIME)
DEGREES = 180 / np.pi


@pytest.mark.parametrize(
    ("text", "name", "factor"),
    [
        ("rad", "rad", 1.0),
        ("deg", "rad", np.pi / 180),
        ("rpm", "rad/s", np.pi / 30),
        ("mm", "m", 1e-3),
        ("N·m", "N·m", 1.0),
        ("Nm", "N·m", 1.0),
        ("mNm", "N·m", 1e-3),
        ("mV", "V", 1e-3),
        ("m/s^2", "m/s²", 1.0),
        ("1", "1", 1.0),
    ],
)
def test_units_become_si(text: str, name: str, factor: float) -> None:
    assert unit(text).name == name
    assert unit(text).factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize("text", ["radd", "rad/", "°C", "degC"])
def test_unknown_units_are_named(text: str) -> None:
    with pytest.raises(DataError, match=repr(text)):
        unit(text)


def check(
    contract: DataContract, position: Array | None, velocity: Array | None, place: str = "rad", rate: str = "rad/s"
) -> tuple[Note, ...]:
    """Declare raw numbers and let the check look at them."""
    channels: list[ChannelMap] = []
    signals: dict[str, Signal] = {}
    for name, raw, text in (("arm.position", position, place), ("arm.velocity", velocity, rate)):
        if raw is not None:
            channel = channel_map(name, {"column": "x", "unit": text}, "")
            channels.append(channel)
            signals[name] = Signal(name, channel.unit.name, TIME, channel.to_si(raw))
    return check_units(signals, channels, contract)


def test_consistent_channels_pass(contract: DataContract) -> None:
    rng = np.random.default_rng(0)
    assert check(contract, ANGLE, SPEED + 0.5 * rng.normal(size=len(TIME))) == ()
    assert check(contract, ANGLE * DEGREES, SPEED * DEGREES, "deg", "deg/s") == ()
    assert check(contract, np.round(ANGLE / 0.003) * 0.003, None) == ()
    assert check(contract, np.zeros(len(TIME)), np.zeros(len(TIME))) == ()


@pytest.mark.parametrize(
    ("position", "velocity", "place", "rate", "remedy"),
    [
        (ANGLE * DEGREES, SPEED, "rad", "rad/s", "arm.position is in degrees (declared 'rad'; write unit: deg)"),
        (ANGLE, SPEED * DEGREES, "rad", "rad/s", "arm.velocity is in degrees (declared 'rad/s'; write unit: deg/s)"),
        (ANGLE, SPEED, "deg", "rad/s", "arm.position is in radians (declared 'deg'; write unit: rad)"),
        (ANGLE, SPEED, "rad", "deg/s", "arm.velocity is in radians (declared 'deg/s'; write unit: rad/s)"),
    ],
)
def test_position_against_velocity(
    contract: DataContract, position: Array, velocity: Array, place: str, rate: str, remedy: str
) -> None:
    with pytest.raises(DataError, match=r"factor 57\.3 = 180/π is suspected") as caught:
        check(contract, position, velocity, place, rate)
    assert remedy in str(caught.value)


def test_sign_and_scale_of_a_velocity_are_noted(contract: DataContract) -> None:
    (flipped,) = check(contract, ANGLE, -SPEED)
    assert flipped.kind == "sign"
    assert "opposite sign" in flipped.message
    (geared,) = check(contract, ANGLE, SPEED / 6)
    assert geared.kind == "unit"
    assert "6 times" in geared.message
    assert "rpm" not in geared.message


@pytest.mark.parametrize(
    ("velocity", "declared", "meant", "ratio"),
    [
        (SPEED * 60 / (2 * np.pi), "rad/s", "rpm", "0.105"),
        (SPEED * 60 / (2 * np.pi), "deg/s", "rpm", "6"),
        (SPEED * DEGREES, "rpm", "deg/s", "0.167"),
        (SPEED, "rpm", "rad/s", "9.54"),
    ],
)
def test_a_velocity_in_another_usual_unit_is_a_fault(
    contract: DataContract, velocity: Array, declared: str, meant: str, ratio: str
) -> None:
    (fault,) = check(contract, ANGLE, velocity, rate=declared)
    assert (fault.kind, fault.signal) == ("fault", "arm.velocity")
    assert fault.message.startswith(
        f"Unit: the derivative of arm.position is {ratio} times arm.velocity, as if its numbers were in {meant} "
        f"(declared {declared!r}). Write unit: {meant}"
    )
    assert check(contract, ANGLE, velocity, rate=meant) == ()


@pytest.mark.parametrize(("raw_turn", "declared", "remedy"), [(360.0, "rad", "deg"), (2 * np.pi, "deg", "rad")])
@pytest.mark.parametrize("counts", [1024, 2048, 2000, 16384])
def test_an_encoders_step_tells_the_unit(
    contract: DataContract, raw_turn: float, declared: str, remedy: str, counts: int
) -> None:
    step = raw_turn / counts
    angle = 0.1 * ANGLE * raw_turn / (2 * np.pi)  # slow enough that its speed alone says nothing
    with pytest.raises(DataError, match=rf"into {counts} counts: the factor 57\.3.*Write unit: {remedy}"):
        check(contract, step * np.round(angle / step), None, declared)


@pytest.mark.parametrize("step", [1e-2, 1e-3, 5e-4, 2 * np.pi / 2048, 2 * np.pi / 5000, 3.81e-4, 2.9e-3])
def test_steps_of_radians_raise_no_alarm(contract: DataContract, step: float) -> None:
    assert check(contract, step * np.round(ANGLE / step), None) == ()


def test_a_joint_faster_than_any_is_suspected(contract: DataContract) -> None:
    with pytest.raises(DataError, match=r"turns at .* faster than 200 rad/s: the factor 57\.3.*unit: deg"):
        check(contract, ANGLE * DEGREES, None)
    with pytest.raises(DataError, match=r"arm\.velocity .* unit: deg/s if .*, unit: rpm if"):
        check(contract, None, SPEED * DEGREES)


@pytest.mark.parametrize(("text", "meant"), [("rmp", "rpm"), ("RPM", "rpm"), ("mms", "mm/s"), ("Nmm/", "mm/s")])
def test_a_misspelt_unit_is_told_the_nearest(text: str, meant: str) -> None:
    with pytest.raises(DataError, match=f"There is no unit {text!r} .*Did you mean {meant!r}"):
        unit(text)


@pytest.mark.parametrize("text", ["grad", "Grad"])
def test_a_degree_in_german_is_no_gon(text: str) -> None:
    with pytest.raises(DataError, match=r"may be a degree or a gon\. Write deg, or gon"):
        unit(text)
    assert unit("gon").factor == pytest.approx(np.pi / 200)
