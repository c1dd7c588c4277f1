"""How gyroscopes sit on what joints move: unit, order and signs of their columns, by how the joints turn them."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from dr_lab.proposal.gyros import TURNS, Compared, Gyro, least, orders
from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.sensors import NO_UNIT, Sensed
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series

_AXES = "xyz"
_GYRO = int(mujoco.mjtSensor.mjSENS_GYRO)


@dataclass(frozen=True)
class _Mounting:
    """Which axis of the model each column of a gyroscope reads, with which sign and in which unit.

    Attributes:
        unit: of the numbers.
        axes: of the model, one for each column.
        signs: likewise.
        left: share of the rates' squares that is left.
        changes: columns that read another axis than they say, and columns that are turned.
    """

    unit: str
    axes: tuple[int, ...]
    signs: tuple[int, ...]
    left: float
    changes: int


def worn(model: mujoco.MjModel, sensed: Sequence[Output]) -> dict[str, dict[int, Series]]:
    """By the name of a gyroscope, which series is which of its axes.

    Args:
        model: the robot's.
        sensed: what sensors read.
    """
    found = defaultdict[str, dict[int, Series]](dict)
    for output in sensed:
        _, name, *axis = output.channel.split(".")
        if int(model.sensor(name).type[0]) == _GYRO:
            letters = axis[0] if axis else _AXES
            found[name] |= {_AXES.index(letter): part for letter, part in zip(letters, output.parts, strict=True)}
    return dict(found)


def mounted(sensed: Sensed, found: Positions, settings: ProposalSettings) -> Sensed:
    """What sensors read, gyroscopes in the unit and with the axes with which they turn as the joints do.

    Args:
        sensed: as the names say it.
        found: the joints' positions, with the gyroscopes that were compared with them.
        settings: which share of the squares may be left, and how close counts as equal.
    """
    if found.gyros is None or found.found is None:
        return sensed
    for gyro, compared in found.gyros.compared(found.found.readings):
        sensed = _mounted(sensed, gyro, compared, settings)
    return sensed


def _mounted(sensed: Sensed, gyro: Gyro, compared: Compared, settings: ProposalSettings) -> Sensed:
    every = [*_mountings(gyro, compared)]
    as_modelled = min((each for each in every if not each.changes), key=lambda each: each.left)
    left = least(gyro, compared)
    if left > settings.fits:
        return _unlike(sensed, gyro, left)
    most = settings.near * left + settings.close
    best = min((each for each in every if each.left <= most), key=lambda each: (each.changes, each.left))
    mine = [each for each in sensed.outputs if each.channel.split(".")[1] == gyro.sensor]
    read = {_AXES.index(letter): part for each in mine for letter, part in _parts(each)}
    parts = {axis: (read[own], sign) for own, axis, sign in zip(gyro.axes, best.axes, best.signs, strict=True)}
    why = f"turns as the joints do, which leaves {best.left:.1%}"
    outputs = [each for each in sensed.outputs if each not in mine]
    said = {part.words.unit for part in read.values()} - {"", best.unit}
    doubts = [each for each in sensed.doubts if not each.startswith(f"sensor.{gyro.sensor}: {NO_UNIT}")]
    doubts += [f"sensor.{gyro.sensor}: named {', '.join(said)}, but it turns as {best.unit} would."] if said else []
    if best.changes:
        doubts.append(_told(gyro, best, as_modelled, read))
    return replace(sensed, outputs=[*outputs, *_outputs(gyro.sensor, parts, best.unit, why)], doubts=doubts)


def _mountings(gyro: Gyro, compared: Compared) -> Iterator[_Mounting]:
    """Every order and sign of the axes, in every unit."""
    for axes, signs in orders(gyro):
        changes = sum(a != b for a, b in zip(axes, gyro.axes, strict=True)) + signs.count(-1)
        for unit, factor in TURNS.items():
            yield _Mounting(unit, axes, signs, compared.left(factor, axes, signs), changes)


def _parts(output: Output) -> Iterator[tuple[str, Series]]:
    """The axes that an output reads."""
    _, _, *axis = output.channel.split(".")
    return zip(axis[0] if axis else _AXES, output.parts, strict=True)


def _outputs(sensor: str, parts: Mapping[int, tuple[Series, int]], unit: str, why: str) -> list[Output]:
    """One channel where all three axes count alike, else one for each."""
    ordered = [parts[axis] for axis in sorted(parts)]
    if len(ordered) == len(_AXES) and all(sign == 1 for _, sign in ordered):
        return [Output(f"sensor.{sensor}", tuple(part for part, _ in ordered), unit, 1, 0.0, wrap=False, why=why)]
    return [
        Output(f"sensor.{sensor}.{_AXES[axis]}", (part,), unit, sign, 0.0, wrap=False, why=why)
        for axis, (part, sign) in sorted(parts.items())
    ]


def _told(gyro: Gyro, best: _Mounting, as_modelled: _Mounting, read: Mapping[int, Series]) -> str:
    """How the columns are read in place of what their names say."""
    listed = ", ".join(
        f"{_AXES[axis]} = {'−' * (sign < 0)}{read[own].place}"
        for own, axis, sign in sorted(zip(gyro.axes, best.axes, best.signs, strict=True), key=lambda each: each[1])
    )
    return (
        f"sensor.{gyro.sensor} does not turn as the joints turn its site, which would leave {as_modelled.left:.0%} of "
        f"its squares; read as {listed} it leaves {best.left:.1%}. If it is mounted so, turn the site in the model "
        "instead."
    )


def _unlike(sensed: Sensed, gyro: Gyro, left: float) -> Sensed:
    """What is unsure of a gyroscope that turns as no order and signs of its axes would."""
    doubt = (
        f"sensor.{gyro.sensor} does not turn as the joints turn its site: whatever the order, signs and unit of its "
        f"axes, {left:.0%} of its squares are left. Is it mounted askew, on another body, or does it stand still?"
    )
    return replace(sensed, doubts=[*sensed.doubts, doubt])
