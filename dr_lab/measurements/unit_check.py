"""Angles in degrees that are declared as radians, and the other way round; times in another unit than declared."""

from collections.abc import Mapping, Sequence

import numpy as np

from dr_lab.channel_names import POSITION, VELOCITY, joint_of, quantity
from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import period
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.lattice import lattice_step
from dr_lab.measurements.signal_map import ChannelMap
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.trajectory import Array, Note, Signal

_DEGREES = 180.0 / np.pi
# What rates of joints are in, beside what they are declared; in rad/s.
_RATES = {"rad/s": 1.0, "deg/s": np.pi / 180.0, "rpm": np.pi / 30.0}
# What a derivative is too large by where times in s are declared in these units; too small by in the other case.
_TIMES = {"ms": 1e3, "µs": 1e6, "ns": 1e9}
_SUSPICION = "the factor 57.3 = 180/π is suspected"
# Half-width of the derivative's window, in sample periods.
_REACH = 5
# Samples of a long signal that are looked at.
_MOST = 10_000
# Below this correlation a derivative says nothing about a velocity channel.
_CORRELATED = 0.9
_RAD_PER_S = ("rad", "rad/s")
# Numbers of steps per turn that encoders and digital angles have.
_POWERS = 2.0 ** np.arange(8, 25)
_DECADES = np.outer([1, 2, 4, 5, 8], 10.0 ** np.arange(2, 7)).ravel()
_COUNTS = np.sort(np.concatenate([_POWERS, _DECADES]))


def check_units(
    signals: Mapping[str, Signal], channels: Sequence[ChannelMap], contract: DataContract
) -> tuple[Note, ...]:
    """Look for the factor 57.3 between what is declared and what the numbers say.

    Three signs: the derivative of a joint's position against its velocity channel; an encoder's step that divides a
    turn in the other unit into a usual number of counts; a joint that turns faster than any does.

    Args:
        signals: cleaned outputs by channel name, in SI.
        channels: their maps.
        contract: thresholds.

    Returns:
        Notes of weaker contradictions: a velocity of the other sign or another scale. It is a note of kind ``fault``
        where another usual unit of the velocity explains the scale.

    Raises:
        DataError: degrees are suspected; the message names the channel and the remedy.
    """
    by_name = {channel.name: channel for channel in channels}
    notes: list[Note] = []
    for name, channel in by_name.items():
        partner = by_name.get(f"{joint_of(name)}.{VELOCITY}")
        if quantity(name) == POSITION and partner and partner.name in signals and signals[name].value.ndim == 1:
            notes += _compare(signals[name], signals[partner.name], channel, partner, contract)
        if channel.unit.name in _RAD_PER_S and signals[name].value.ndim == 1:
            _check_step(signals[name], channel, contract)
            _check_speed(signals[name], channel, contract)
    return tuple(notes)


def _compare(
    position: Signal, velocity: Signal, place: ChannelMap, rate: ChannelMap, contract: DataContract
) -> list[Note]:
    """Ratio of d(position)/dt to velocity by least squares."""
    inside = np.flatnonzero((velocity.time >= position.time[0]) & (velocity.time <= position.time[-1]))
    if len(inside) < 2:
        return []
    inside = inside[:: len(inside) // _MOST + 1]
    measured = velocity.value[inside]
    slope = _slope(position, velocity.time[inside])
    norm = float(np.sqrt((measured @ measured) * (slope @ slope)))
    if norm == 0.0 or abs(slope @ measured) < _CORRELATED * norm:
        return []
    ratio = float(slope @ slope) / float(slope @ measured)
    _require_seconds(ratio, place, rate, contract)
    for factor, wrong in ((_DEGREES, place), (1.0 / _DEGREES, rate)):
        if abs(np.log(abs(ratio) / factor)) < contract.unit_ratio:
            other = rate if wrong is place else place
            raise DataError(
                f"The derivative of {place.name} is {abs(ratio):.3g} times {rate.name}: {_SUSPICION}. Either "
                f"{wrong.name} is in degrees (declared {wrong.unit.given!r}; write {_degrees(wrong)}), or "
                f"{other.name} is in radians (declared {other.unit.given!r}; write {_radians(other)})."
            )
    return _weaker(ratio, rate, place.name, contract)


def _require_seconds(ratio: float, place: ChannelMap, rate: ChannelMap, contract: DataContract) -> None:
    """Refuse times of a table whose unit explains the ratio of derivative to velocity."""
    for name, factor in _TIMES.items() if not place.topic else ():
        for size, read in ((factor, f"s that are read as {name}"), (1 / factor, f"{name} that are read as s")):
            if abs(np.log(abs(ratio) / size)) < contract.unit_ratio:
                raise DataError(
                    f"The derivative of {place.name} is {abs(ratio):.3g} times {rate.name}: the times seem to be "
                    f"{read}. Correct time.unit or time.scale; if they are right, the unit of one of both channels."
                )


def _weaker(ratio: float, rate: ChannelMap, place: str, contract: DataContract) -> list[Note]:
    if ratio < 0:
        message = f"{rate.name} has the opposite sign of the derivative of {place} (ratio {ratio:.3g}); check sign."
        return [Note("sign", rate.name, message)]
    if abs(np.log(ratio)) <= contract.velocity_ratio:
        return []
    told = f"the derivative of {place} is {ratio:.3g} times {rate.name}"
    if meant := _meant(ratio, rate, contract):
        message = (
            f"Unit: {told}, as if its numbers were in {meant} (declared {rate.unit.given!r}). Write unit: {meant}; if "
            "the unit is right, check scale and gear ratio of both."
        )
        return [Note("fault", rate.name, message)]
    return [Note("unit", rate.name, f"Unit: {told}; check unit, scale and gear ratio of both.")]


def _meant(ratio: float, rate: ChannelMap, contract: DataContract) -> str:
    """The unit in which a joint's velocity would be `ratio` times as fast; empty where it is none of the usual ones."""
    if rate.unit.name != "rad/s":
        return ""
    meant = (
        text for text, size in _RATES.items() if abs(np.log(ratio * rate.unit.factor / size)) < contract.unit_ratio
    )
    return next(meant, "")


def _check_step(signal: Signal, channel: ChannelMap, contract: DataContract) -> None:
    if channel.unit.name != "rad" or contract.unit_quantum == 0.0:
        return
    step = lattice_step(signal.value)
    if step is None:
        return
    own = step / channel.unit.factor
    declared_degrees = abs(channel.unit.factor * _DEGREES - 1.0) < 1e-9
    if channel.unit.factor != 1.0 and not declared_degrees:
        return
    turn, other_turn = (360.0, 2 * np.pi) if declared_degrees else (2 * np.pi, 360.0)
    if _usual(turn / own, contract) or not _usual(other_turn / own, contract):
        return
    other = "rad" if declared_degrees else "deg"
    raise DataError(
        f"{channel.name} is declared {channel.unit.given!r}, but its steps of {own:.6g} divide a turn of "
        f"{other_turn:.5g} {other} into {other_turn / own:.0f} counts: {_SUSPICION}. Write unit: {other}, or set "
        "contract.unit_quantum: 0 if the unit is right."
    )


def _usual(counts: float, contract: DataContract) -> bool:
    return bool((np.abs(_COUNTS / counts - 1.0) < contract.unit_quantum).any())


def _check_speed(signal: Signal, channel: ChannelMap, contract: DataContract) -> None:
    """Refuse numbers in radians that turn as fast as degrees would; turns a minute are neither."""
    if channel.unit.factor not in (1.0, 1.0 / _DEGREES):
        return
    speed = np.abs(
        signal.value if channel.unit.name == "rad/s" else _slope(signal, signal.time[:: len(signal) // _MOST + 1])
    )
    typical_peak = float(np.quantile(speed, 0.99))
    if typical_peak <= contract.speed_limit:
        return
    turns = ", unit: rpm if they are turns a minute" if channel.unit.name == "rad/s" else ""
    raise DataError(
        f"{channel.name} (declared {channel.unit.given!r}) turns at {typical_peak:.4g} rad/s, faster than "
        f"{contract.speed_limit:g} rad/s: {_SUSPICION}. Write {_degrees(channel)} if the numbers are degrees{turns}, "
        "wrap: true if the angle jumps by full turns, or raise measurements.contract.speed_limit if it is that fast."
    )


def _slope(signal: Signal, at: Array) -> Array:
    half_width = _REACH * period(signal.time)
    return local_polynomial(signal, at, half_width, degree=2).slope


def _degrees(channel: ChannelMap) -> str:
    return "unit: deg" if channel.unit.name == "rad" else "unit: deg/s"


def _radians(channel: ChannelMap) -> str:
    return "unit: rad" if channel.unit.name == "rad" else "unit: rad/s"
