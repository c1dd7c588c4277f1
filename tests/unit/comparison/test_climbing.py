"""Longer windows are tried where shorter ones leave a gap or a doubt, and believed where they settle it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from diagnosis_machines import comparison_settings, evidence_settings, windows_settings

from dr_lab.comparison import climbing
from dr_lab.comparison.comparison import ComparisonSettings
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.errors import DataError


@dataclass(frozen=True)
class Answer:
    """A ladder of which only the verdict is known, what confirms it, and whether noise alone remains.

    `enough` says whether the windows that confirm are enough to know, `channels` holds χ² of some.
    """

    kind: str
    steps: tuple[str, ...] = ()
    status: str = "confirmed"
    chi2: float = 100.0
    enough: bool = True
    channels: tuple[float, ...] = ()
    instrumental: bool = False

    @property
    def found(self) -> tuple[str, ...]:
        return self.steps

    @property
    def confirmation(self) -> SimpleNamespace | None:
        return SimpleNamespace(status=self.status, enough=self.enough) if self.steps else None

    @property
    def models(self) -> list[SimpleNamespace]:
        known = {str(chi2): channel(chi2) for chi2 in self.channels}
        return [SimpleNamespace(held_out=replace(score([self.chi2] * 8), channels=known))]

    @property
    def base(self) -> SimpleNamespace:
        return fitted(self.chi2, instrumental=self.instrumental)

    def verdict(self, settings: EvidenceSettings) -> str:
        del settings
        return self.kind

    def with_laws(self, *known: object) -> "Answer":
        del known
        return self


@dataclass(frozen=True)
class Windowed:
    """A study of logs that have room for windows of a certain length, most for those of another; else unknown."""

    settings: ComparisonSettings
    room: float
    scales: None = None
    compiled: None = None

    unlogged: object = None
    short: float = 9.0

    @property
    def bench(self) -> SimpleNamespace:
        logs = ("a", "b", "c", "d") if self.settings.windows.length <= self.short else ("a",)
        fit = SimpleNamespace(unlogged=self.unlogged, logs=logs)
        return SimpleNamespace(evidence=self.settings.evidence, fit=fit, held_out=SimpleNamespace(logs=logs[:1]))

    def with_settings(self, settings: ComparisonSettings) -> "Windowed":
        if settings.windows.length > self.room:
            raise DataError("No log holds a window.")
        return replace(self, settings=settings)


def fitted(chi2: float, *, instrumental: bool = False) -> SimpleNamespace:
    """A model that leaves so much of one channel."""
    left = replace(channel(chi2), instrumental=instrumental)
    return SimpleNamespace(held_out=replace(score([chi2] * 8), channels={"hinge.position": left}))


DIVERGES = float("inf")
NOISE = Answer("none", chi2=1.0)
NOTHING, NAMED = Answer("unexplained"), Answer("named", ("friction",))
DOUBTFUL = Answer("equivalent", ("drag",), "undecided")


@pytest.mark.parametrize(
    ("answers", "room", "length", "kind"),
    [
        ([NAMED], 9.0, 0.3, "named"),
        ([NOISE], 9.0, 0.3, "none"),
        ([NOISE, 1.0, 9.0, NAMED], 9.0, 2.7, "named"),  # noise alone in 0.9 s, too, and a gap in 2.7 s
        ([NOISE, 9.0, NOTHING, 9.0, NAMED], 9.0, 2.7, "named"),
        ([NOISE, 9.0, NOTHING, 9.0, NOTHING], 9.0, 0.9, "unexplained"),  # the first that show the gap
        ([NOISE, 9.0, NAMED], 0.5, 0.3, "none"),
        ([replace(NOISE, chi2=8.0), 11.0, 12.0], 9.0, 0.3, "none"),  # coloured noise, which grows little
        ([replace(NOISE, chi2=8.0), 11.0, 30.0, NAMED], 9.0, 2.7, "named"),
        ([NOTHING, NAMED], 9.0, 0.9, "named"),
        ([NOTHING, NOTHING, NAMED], 9.0, 2.7, "named"),
        ([NOTHING, NOTHING, NOTHING], 9.0, 0.3, "unexplained"),
        ([NOTHING, Answer("none"), NOTHING], 9.0, 0.3, "unexplained"),  # a gap is not gone in longer windows
        ([NOTHING, NOTHING, Answer("none", chi2=2.0, instrumental=True)], 9.0, 2.7, "none"),  # but was coloured noise
        ([NOTHING, NAMED], 0.5, 0.3, "unexplained"),  # the logs have no room for them
        ([DOUBTFUL, NAMED], 9.0, 0.9, "named"),
        ([DOUBTFUL, NOTHING], 9.0, 0.3, "equivalent"),  # 2.7 s are not tried
        ([DOUBTFUL, replace(NAMED, status="undecided")], 9.0, 0.3, "equivalent"),  # one doubt for another
        ([DOUBTFUL, Answer("none")], 9.0, 0.3, "equivalent"),
        ([replace(DOUBTFUL, enough=False)], 9.0, 0.3, "equivalent"),  # longer ones are fewer, and cannot confirm either
        ([NOTHING, DOUBTFUL], 9.0, 0.9, "equivalent"),
        ([replace(DOUBTFUL, chi2=1.0)], 9.0, 0.3, "equivalent"),  # nothing but noise is left to ask
    ],
)
def test_the_shortest_windows_that_explain_the_gap(
    monkeypatch: pytest.MonkeyPatch, answers: list[Answer | float], room: float, length: float, kind: str
) -> None:
    """Numbers are χ² of the model calibrated to the longer windows of one that left noise alone."""
    left, confidence = [*answers], list[float]()

    def climb(made: Study, *known: object) -> Ladder:
        del known
        confidence.append(made.bench.evidence.confidence)
        return cast(Ladder, left.pop(0))

    def base(made: Study, ascent: object, short: object = None) -> SimpleNamespace:
        del made, ascent
        told = short is not None and left and isinstance(left[0], float)
        return fitted(cast(float, left.pop(0)) if told else 1.0)

    monkeypatch.setattr(climbing, "_ladder", climb)
    monkeypatch.setattr(climbing, "_base", base)
    windows, evidence = windows_settings(length=0.3, longest=2.7), evidence_settings(confidence=0.97)
    first = cast(Study, Windowed(comparison_settings(windows=windows, evidence=evidence), room))
    found, ladder = climbing.climbed(first, {}, most=1, watch=Silence())
    assert not left or room < 0.9
    assert found.settings.windows.length == pytest.approx(length)
    assert ladder.verdict(evidence) == kind
    assert confidence == pytest.approx([0.97, 0.99, 0.99][: len(confidence)])  # Bonferroni over three lengths


@pytest.mark.parametrize(("first", "short", "length"), [(NOTHING, 0.5, 0.3), (NOTHING, 9.0, 0.9), (NOISE, 0.5, 0.3)])
def test_windows_for_which_most_logs_have_no_room_are_not_asked(
    monkeypatch: pytest.MonkeyPatch, first: Answer, short: float, length: float
) -> None:
    answers = iter([first, NAMED])
    monkeypatch.setattr(climbing, "_ladder", lambda *_: next(answers))
    monkeypatch.setattr(climbing, "_base", lambda *_: fitted(9.0))
    settings = comparison_settings(windows=windows_settings(length=0.3, longest=2.7))
    study = cast(Study, Windowed(settings, 9.0, short=short))
    assert climbing.climbed(study, {}, most=1, watch=Silence())[0].settings.windows.length == pytest.approx(length)


def test_longer_windows_are_not_asked_of_commands_that_changed_unlogged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(climbing, "_ladder", lambda *_: NOISE)
    monkeypatch.setattr(climbing, "_base", lambda *_: fitted(9.0))
    windows = windows_settings(length=0.3, longest=2.7)
    study = cast(Study, Windowed(comparison_settings(windows=windows), 9.0, unlogged="something"))
    found, ladder = climbing.climbed(study, {}, most=1, watch=Silence())
    assert (found, ladder) == (study, NOISE)


@pytest.mark.parametrize(
    ("first", "chi2", "share"),
    [
        (DOUBTFUL, [16.0, 400.0], 0.8),  # of the channel that is explained best
        (DOUBTFUL, [0.5, 400.0], 0.2),
        (NOTHING, [16.0, 400.0], 0.2),  # what explains the gap may leave noise alone
    ],
)
def test_a_doubt_is_asked_again_with_a_step_that_does_not_show_beside_what_is_left(
    monkeypatch: pytest.MonkeyPatch, first: Answer, chi2: list[float], share: float
) -> None:
    shares, answers = list[float](), iter([replace(first, channels=tuple(chi2)), NOTHING, NOTHING])

    def climb(made: Study, *known: object) -> Ladder:
        del known
        shares.append(made.settings.model_check.least_share)
        return cast(Ladder, next(answers))

    monkeypatch.setattr(climbing, "_ladder", climb)
    monkeypatch.setattr(climbing, "_base", lambda *_: fitted(9.0))
    check = replace(comparison_settings().model_check, least_share=0.2)
    settings = comparison_settings(windows=windows_settings(length=0.3, longest=2.7), model_check=check)
    study = cast(Study, Windowed(settings, 9.0))
    climbing.climbed(study, {}, most=1, watch=Silence())
    assert shares[:2] == pytest.approx([0.2, share])


@dataclass(frozen=True)
class Rising:
    """A ladder of models of which only the errors in windows with known starts are known, by their number of steps."""

    errors: tuple[float, ...]
    floor: bool = False

    @property
    def steps(self) -> tuple[float, ...]:
        return self.errors[1:]

    @property
    def models(self) -> list[SimpleNamespace]:
        def model(k: int) -> SimpleNamespace:
            chi2 = 1.0 if self.floor and k == len(self.errors) - 1 else 100.0
            return SimpleNamespace(model=k, fit=SimpleNamespace(z=None), held_out=score([chi2] * 8))

        return [model(k) for k in range(len(self.errors))]

    def without_last(self) -> "Rising":
        return replace(self, errors=self.errors[:-1])


def channel(chi2: float) -> ChannelScore:
    """A channel of eight windows with ten residuals each."""
    return ChannelScore(np.full(8, 10 * chi2), np.full(8, 10.0), 1.0, False)


def score(chi2: list[float]) -> Score:
    """A score of windows with ten residuals each, of which some diverge."""
    lost = np.isinf(chi2)
    count = np.where(lost, 0.0, 10.0)
    sums = np.where(lost, 0.0, 10 * np.where(lost, 0.0, chi2))
    return Score(float(sums.sum() / count.sum()), {}, {}, {}, sums, count, np.arange(len(chi2)), int(lost.sum()))


@pytest.fixture
def predicting(monkeypatch: pytest.MonkeyPatch) -> Callable[[Sequence[Score], Rising], int]:
    """How many effects are kept of a ladder whose models predict with these scores."""

    def kept(scores: Sequence[Score], ladder: Rising) -> int:
        made = SimpleNamespace(bench=SimpleNamespace(evidence=evidence_settings()), predicted=None, fits=fits)
        monkeypatch.setattr(climbing, "score_of", lambda k, _: scores[k])
        monkeypatch.setattr(climbing, "folds", lambda windows: (windows, None))
        return len(climbing.as_far_as_it_predicts(cast(Study, made), cast(Ladder, ladder)).steps)

    return kept


Predicting = Callable[[Sequence[Score], Rising], int]


@pytest.mark.parametrize(
    ("errors", "kept"),
    [
        ((90.0, 40.0, 20.0), 2),
        ((90.0, 40.0, 41.0), 1),
        ((90.0, 40.0, 41.0, 42.0), 1),
        ((90.0, 40.0, 50.0, 30.0), 3),  # what lies below a step that predicts better is not asked
        ((90.0, 95.0), 1),  # the first is left to the windows that confirm
    ],
)
def test_effects_that_do_not_predict_better_are_dropped(
    predicting: Predicting, errors: tuple[float, ...], kept: int
) -> None:
    scores = [score([error] * 8) for error in errors]
    assert predicting(scores, Rising(errors)) == kept
    assert predicting(scores, Rising(errors, floor=True)) == len(errors) - 1


@pytest.mark.parametrize(
    ("before", "after", "kept"),
    [
        ([50.0] * 8, [40.0] * 7 + [200.0], 1),  # a wild window raises the error of all
        ([40.0] * 7 + [100.0], [46.0] * 8, 1),  # a wild window alone gets better
        ([40.0] * 8, [30.0] * 4 + [DIVERGES] * 4, 1),
        ([40.0] * 4 + [DIVERGES] * 4, [45.0] * 8, 2),
    ],
)
def test_all_windows_and_the_typical_one_must_get_better(
    predicting: Predicting, before: list[float], after: list[float], kept: int
) -> None:
    assert predicting([score([90.0] * 8), score(before), score(after)], Rising((90.0, 50.0, 60.0))) == kept


def fits(model: int, z: None, windows: None) -> tuple[int, None]:
    """The number of a model in place of its simulation."""
    del z, windows
    return model, None
