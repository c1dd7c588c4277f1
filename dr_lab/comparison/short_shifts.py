"""What a shift in time would explain that is too short to be named."""

from dr_lab.diagnosis.evidence.bench import Bench
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.reports.gap_entries import SHORT_SHIFT, NoteEntry
from dr_lab.reports.quantity import number


def short_shifts(bench: Bench, ladder: Ladder) -> list[NoteEntry]:
    """Note on the best of the shifts in time that lower the last model's error beyond doubt, but are too short.

    A shift by less than `Bench.timing_resolution` may be the integrator's own error, or what a command does between
    two samples. Where the model leaves noise alone there is nothing to say.
    """
    if at_floor(ladder.models[-1].held_out, bench.evidence):
        return []
    found = (c for c in ladder.rungs[-1].ranking if c.final and not c.resolved and _gains(c, bench))
    best = max(found, key=lambda c: c.gain.total, default=None)
    return [] if best is None else [NoteEntry(_told(best, bench), SHORT_SHIFT)]


def _gains(candidate: Candidate, bench: Bench) -> bool:
    return supported(candidate.gain, len(candidate.effect.parameters), bench.evidence)


def _told(candidate: Candidate, bench: Bench) -> str:
    shift, values = candidate.effect, candidate.fitted_model.values()
    long = ", ".join(f"{number(1e3 * values[p.name], 3)} ms" for p in shift.parameters)
    return (
        f"`{shift.label}` ({long}) would leave χ² {number(candidate.fitted_model.held_out.chi2)}. It is not named, for "
        f"a shift of less than {number(1e3 * bench.timing_resolution, 3)} ms may be that of the time step, or of "
        "commands that are logged too rarely. To know, give the model a finer timestep, log commands more often, or "
        "say what they did between their samples (measurements.commands.NAME.between)."
    )
