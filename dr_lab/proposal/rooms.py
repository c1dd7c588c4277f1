"""Held-out logs that hold windows as the other verbs cut them, so that models can be judged by them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dr_lab.comparison.comparison import ComparisonSettings
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.windows import window_begins
from dr_lab.trajectory import Log, MeasurementSet

_SHARE = 0.9  # of a length, that is tried next
_SHORTEST = 0.1  # share of the length that is asked for, below which none is tried
_DIGITS = 2  # of a length that is proposed


@dataclass(frozen=True)
class Rooms:
    """How many windows each log holds, by its name.

    Attributes:
        scored: windows with a run-in before the part that is scored, as of held-out logs.
        fitted: windows without.
    """

    scored: Mapping[str, int]
    fitted: Mapping[str, int]

    def held(self, held: Sequence[str], names: Sequence[str], several: int) -> tuple[str, ...]:
        """The held-out logs, where one with too few windows is exchanged for the nearest that holds enough.

        Where none holds enough, one with more is taken. Fitted logs keep a window.

        Args:
            held: names of those that are held out at first.
            names: of all logs in order.
            several: windows that are enough.
        """
        chosen = list(held)
        for place, name in enumerate(chosen):
            others = [*chosen[:place], *chosen[place + 1 :]]
            here = names.index(name)
            rest = [n for n in names if n not in others and self._fits([k for k in names if k not in (*others, n)])]
            best = max((min(self.scored[n], several) for n in rest), default=0)
            if min(self.scored[name], several) < best:
                enough = [n for n in rest if min(self.scored[n], several) == best]
                chosen[place] = min(enough, key=lambda n: (abs(names.index(n) - here), n))
        return tuple(name for name in names if name in chosen)

    def may_replace(self, held: Sequence[str], several: int) -> set[str]:
        """The logs that hold as many windows as the poorest of the held-out ones, or enough."""
        least = min((min(self.scored[name], several) for name in held), default=0)
        return {name for name, windows in self.scored.items() if windows >= least}

    def _fits(self, names: Sequence[str]) -> bool:
        return any(self.fitted[name] for name in names)


def rooms_of(measured: MeasurementSet, checks: ComparisonSettings) -> Rooms:
    """How many windows the logs hold that are used."""
    logs = (*measured.fit, *measured.held_out)
    return Rooms(
        *(
            {log.name: len(window_begins(log, measured.gaps, settings)) for log in logs}
            for settings in (checks.predicted, checks.windows)
        )
    )


def doubt_of_room(measured: MeasurementSet, checks: ComparisonSettings) -> str:
    """What to do where no held-out log, or no fitted one, holds a window; empty where some do."""
    asked = ((measured.held_out, checks.predicted), (measured.fit, checks.windows))
    if all(not logs or _holds(logs, measured, settings) for logs, settings in asked):
        return ""
    need, lengths = _span(checks.predicted), [checks.windows.length]
    while lengths[-1] > _SHORTEST * checks.windows.length:
        length = float(f"{_SHARE * lengths[-1]:.{_DIGITS}g}")
        if all(not logs or _holds(logs, measured, settings.of_length(length)) for logs, settings in asked):
            return (
                f"No log that can be held out holds a gapless window of {need:.3g} s, which the other verbs ask "
                f"for. Give them windows.length={length:g}, or record for longer."
            )
        lengths.append(length)
    return f"No log holds a gapless window of {need:.3g} s, nor a shorter one of use: record for longer."


def _holds(logs: Sequence[Log], measured: MeasurementSet, settings: WindowSettings) -> bool:
    return any(len(window_begins(log, measured.gaps, settings)) for log in logs)


def _span(settings: WindowSettings) -> float:
    """Time in s that a window takes."""
    return settings.length + settings.run_in + 2 * settings.margin
