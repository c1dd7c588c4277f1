"""Places at which rivals are tried whose parameters bend what they give."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Grids:
    """Values of shape parameters, in order; some are shares of the largest command, speed or range in all logs.

    Attributes:
        delays: of actuators, s.
        lags: time constants of actuators, s.
        ramps: time from zero to the largest command at a limited rate, s.
        limits: of commands and of servos' forces, shares of the largest, falling.
        dead: widths of dead zones, shares of the largest command.
        exponents: of the powers of commands.
        fulls: commands at which a power is right, shares of the largest, rising.
        offsets: of encoders in time, s, from the earliest to the latest.
        filter: largest time constant of an encoder, s.
        velocity_filter: the same of a tachometer.
        stribeck: Stribeck speeds, shares of the joint's largest speed.
        drops: shares of the friction that are lost at high speed.
        rates: at which friction fades, 1/s.
        displacements: of hysteresis, shares of the joint's range.
        ways: over which presliding friction builds up, shares of the joint's range.
        creeps: speeds below which it creeps, shares of the joint's largest speed.
        stops: distances of an end stop from the end of the joint's travel, shares of the travel.
        reaches: distances of a payload from the joint, shares of that of the body's centre.
        stalls: stall forces, shares of the largest force of the actuator.
        speeds: no-load speeds, shares of the joint's largest speed.
        scales: lowest and highest share of its force that a drive delivers, as in the catalogue.
        gains: the same of a position controller's proportional gain.
        drift: fastest of an encoder, shares of the joint's range in a second, as in the catalogue.
        periods: of cogging in a turn.
        discs: periods of an encoder in a turn.
        pitches: of either along a slide, rad/m.
        ratios: of couplings between joints.
    """

    delays: Sequence[float]
    lags: Sequence[float]
    ramps: Sequence[float]
    limits: Sequence[float]
    dead: Sequence[float]
    exponents: Sequence[float]
    fulls: Sequence[float]
    offsets: Sequence[float]
    filter: float
    velocity_filter: float
    stribeck: Sequence[float]
    drops: Sequence[float]
    rates: Sequence[float]
    displacements: Sequence[float]
    ways: Sequence[float]
    creeps: Sequence[float]
    stops: Sequence[float]
    reaches: Sequence[float]
    stalls: Sequence[float]
    speeds: Sequence[float]
    scales: tuple[float, float]
    gains: tuple[float, float]
    drift: float
    periods: Sequence[float]
    discs: Sequence[float]
    pitches: Sequence[float]
    ratios: Sequence[float]
