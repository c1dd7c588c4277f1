"""Scores whose windows have known sums, and the settings by which their evidence is weighed."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.law_settings import LawSettings
from dr_lab.diagnosis.peak_settings import PeakSettings
from dr_lab.diagnosis.settings import EvidenceSettings

SETTINGS = EvidenceSettings(
    most_fits=100,
    least_promise=0.0,
    least_hope=0.5,
    enough_hope=10.0,
    screen_seconds=3.0,
    screen_windows=5,
    confidence=0.99,
    trial_confidence=0.95,
    block=3,
    least_blocks=8,
    least_trusted=3,
    least_clusters=5,
    astray=2.0,
    least_compared=3,
    resamples=2000,
    gain_resamples=20000,
    seed=0,
    threshold=25.0,
    least_gap=0.1,
    least_explained=0.25,
    least_named=0.7,
    growth=2.0,
    penalty=2.0,
    floor=1.1,
    absorbed=1e-3,
    replacement_share=0.2,
    widenings=3,
    rerankings=3,
    peaks=PeakSettings(most=2, near=0.8),
    law=LawSettings(knots=4, factor=2.0, least_closed=0.7),
)


def score(sums: np.ndarray, count: float = 100.0, logs: int = 2) -> Score:
    counts = np.full(len(sums), count)
    log = np.repeat(np.arange(logs), len(sums) // logs)
    return Score(float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, log, 0)


def chi2(windows: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).chisquare(100, windows)


def seen(worse: np.ndarray, better: np.ndarray) -> tuple[Score, Score]:
    """Scores whose fitted windows look like those that score."""
    first, second = (replace(score(sums), foretold=score(sums)) for sums in (worse, better))
    return first, second
