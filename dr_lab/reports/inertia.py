"""What a report says of the bodies' inertial parameters."""

from collections.abc import Mapping, Sequence

from dr_lab.reports.inertia_entries import BodyEntry, InertiaEntry
from dr_lab.reports.quantity import number, uncertain

# Words of Nguyen et al., figaroh (2023), for the condition of an identification.
_WELL, _MODERATE = 100.0, 1000.0


def inertia_told(found: InertiaEntry | None) -> str:
    """Which combinations the logs know, which parameters the prior holds, and what the bodies weigh."""
    if found is None:
        return ""
    return "\n\n".join(part for part in (_sentences(found), _table(found.bodies)) if part)


def _sentences(found: InertiaEntry) -> str:
    lines = [
        f"The logs know {found.known} of {found.parameters} combinations of the inertial parameters{_words(found)}."
    ]
    blind = found.parameters - found.rank
    if found.worst:
        lines.append(f"Poorly known: {'; '.join(map(_combination, found.worst))}.")
    if blind:
        lines.append(f"{blind} more change nothing that was measured, whatever the noise.")
    if found.held:
        names = _by_body(found.held)
        lines.append(f"A weak prior holds these near the model file, for want of data: {names}.")
    return " ".join(lines)


def _words(found: InertiaEntry) -> str:
    if not found.known or found.condition is None:
        return ""
    word = "well" if found.condition < _WELL else "moderately" if found.condition < _MODERATE else "ill"
    return f" (condition {number(found.condition, 3)}: {word} conditioned)"


def _combination(entries: Mapping[str, float | None]) -> str:
    told = [f"{'−' if (value or 0) < 0 else '+'} {abs(value or 0):.2f} `{name}`" for name, value in entries.items()]
    return " ".join(told).removeprefix("+ ").removeprefix("1.00 ")


def _by_body(names: Sequence[str]) -> str:
    """Parameters, those of one body together: ``link1`` mass, shift_x."""
    bodies: dict[str, list[str]] = {}
    for name in names:
        body, _, short = name.partition(".inertial.")
        bodies.setdefault(body, []).append(short)
    return "; ".join(f"`{body}` {', '.join(shorts)}" for body, shorts in bodies.items())


def _table(bodies: Mapping[str, BodyEntry]) -> str:
    rows = [
        f"| `{name}` | {uncertain(body.mass, body.mass_std, 'kg')} | {_place(body)} |" for name, body in bodies.items()
    ]
    return "\n".join(["| body | mass | centre of mass x, y, z in its frame |", "|---|---|---|", *rows])


def _place(body: BodyEntry) -> str:
    return ", ".join(uncertain(value, std, "m") for value, std in zip(body.centre, body.centre_std, strict=True))
