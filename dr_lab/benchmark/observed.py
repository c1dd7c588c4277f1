"""The logs of a case and the study of them, made as a user would: `record`, then `diagnose`."""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.outcome import numbers_of
from dr_lab.comparison.study import Study, prepare
from dr_lab.effects.effect import Effect
from dr_lab.reports.faults import faults_line
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.sources.source import write_logs

Compose = Callable[[str, Sequence[str]], Mapping[str, Any]]
Tell = Callable[[Sequence[NoteEntry]], None]

EXACT = "exact"
_AND = " + "  # between the labels of several hidden effects


@dataclass(frozen=True)
class Observed:
    """A case as the diagnosis sees it.

    Attributes:
        study: model and logs.
        effects: the catalogue.
        truths: what is hidden, as ``effect@site``, which the diagnosis must not see.
        magnitudes: numbers of each truth, by the plant's names, neither.
    """

    study: Study
    effects: Mapping[str, Effect]
    truths: tuple[str, ...]
    magnitudes: Mapping[str, Mapping[str, float]]


def observe(case: Case, compose: Compose) -> Observed:
    """Record a case's logs and prepare their diagnosis.

    Args:
        case: which one.
        compose: gives the arguments of a verb, built from its name and overrides.
    """
    return _observed(case, compose, case.instruments, (), functools.partial(_say_briefly, case.name))


def observe_exactly(case: Case, compose: Compose, seen: Observed) -> Observed:
    """The same motion without noise, clock error or jitter, weighed by the noise that was seen and cut alike.

    Args:
        case: which one.
        compose: as for `observe`.
        seen: the case as the diagnosis saw it.
    """
    noise = seen.study.measurements.noise
    stds = ",".join(f"{channel}:{{noise_std:{float(each.std)!r}}}" for channel, each in noise.items())
    length = seen.study.settings.windows.length
    overrides = [f"++measurements.outputs={{{stds}}}", f"windows.length={length!r}"]
    return _observed(case, compose, EXACT, overrides, lambda _: None)


def _observed(case: Case, compose: Compose, instruments: str, overrides: Sequence[str], tell: Tell) -> Observed:
    with TemporaryDirectory() as name:
        folder = Path(name)
        source = compose("record", case.recording(instruments))["source"]
        write_logs(source, case.seed, folder)
        logs = f"measurements.logs=[{folder}/*.mcap]"
        built = compose("diagnose", [*case.diagnose, logs, *overrides, "threads=1"])
        truth = yaml.safe_load((folder / "truth.yaml").read_text(encoding="utf-8"))
        study = prepare(built["comparison"], tell)
    # A machine that is its own model writes no hidden effect.
    hidden = truth.get("hidden", {"effect": "", "parameters": {}})
    truths = () if case.kind == "none" else tuple(hidden["effect"].split(_AND))
    return Observed(study, built["effects"], truths, numbers_of(truths, hidden["parameters"]))


def _say_briefly(case: str, notes: Sequence[NoteEntry]) -> None:
    """Print the faults of a case's logs in a line; a report of `dr-lab diagnose` says more of them."""
    if told := faults_line(notes):
        print(f"  faulty logs of {case}: {told}")
