"""Units that commands may be in, and which one the motion speaks for."""

import math

from dr_lab.measurements.units import unit as unit_of
from dr_lab.proposal.settings import ProposalSettings

# Sizes of the units that are mistaken for one another, by the SI unit of a command.
UNITS: dict[str, dict[str, float]] = {
    "N·m": {"N·m": 1.0, "mN·m": 1e-3, "kgf·cm": 0.0980665, "kgf·m": 9.80665},
    "N": {"N": 1.0, "mN": 1e-3, "kgf": 9.80665, "kN": 1e3},
    "V": {"V": 1.0, "mV": 1e-3},
    "rad": {"rad": 1.0, "deg": math.pi / 180},
    "m": {"m": 1.0, "mm": 1e-3},
    "rad/s": {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3},
    "1": {"1": 1.0, "percent": 1e-2},
}


def factors(base: str, said: str) -> dict[str, float]:
    """Sizes of the units that numbers may have; one that is said is one if it is of that quantity, or there is none."""
    known = UNITS.get(base, {base: 1.0})
    told = said and (base == "1" or unit_of(said).name == base)
    return {**known, said: unit_of(said).factor} if told else known


def unit_by_gain(
    gain: float, base: str, said: str, settings: ProposalSettings, *, stated: bool
) -> tuple[str, float, list[str]]:
    """Unit and scale of a command by its gain, and what is unsure.

    Args:
        gain: of the numbers over what the control is in.
        base: SI unit of the control.
        said: unit that the numbers' name says, or nothing.
        settings: which gains are near a unit.
        stated: whether numbers without a unit are in that of the control.
    """
    size, known = abs(gain), factors(base, said)
    if said in known:
        left = size / known[said]
        if settings.gain < left < 1 / settings.gain:
            return said, 1.0, _beside_name(size, known[said], said, settings) if base == "1" else []
    name, factor = min(known.items(), key=lambda entry: abs(math.log(size / entry[1])))
    other = bool(said) and said not in known and unit_of(said).dimension != unit_of(base).dimension  # near 1 by chance
    if not other and abs(math.log(size / factor)) < math.log(settings.near_unit):
        contradicts = [f"named {said}, but it moves the joint as {_plain(name)} do."] if said and said != name else []
        return name, 1.0, contradicts
    if settings.gain < size < 1 / settings.gain and stated and not said:
        return base, 1.0, [f"acts {size:.2g} times as strongly as {_plain(base)} would; read as {_plain(base)}."]
    scale = (f"{size:.3g}" if base == "1" else f"{size:.3g} {base}") + (f" per {said}" if other else "")
    return base, float(f"{size:.3g}"), [f"its scale of {scale} is judged from the motion alone; check it."]


def _beside_name(size: float, named: float, said: str, settings: ProposalSettings) -> list[str]:
    """What is unsure of a control without a unit whose column's unit has another size than 1."""
    if named == 1.0 or abs(size / named - 1) < settings.gain_off:
        return []
    return [f"its scale of {named:.3g} is that of {said}, as its name says; the motion alone says {size:.3g}."]


def _plain(name: str) -> str:
    """A unit in words."""
    return "numbers of ctrl" if name == "1" else name
