"""Candidates are ranked anew beside a base that became better, so often at most."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import pytest
from diagnosis_machines import evidence_settings
from pretended_rankings import model

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.search import rank

LEVELS = (20.0, 10.0, 4.0, 1.5, 1.5)  # χ² of the base before and after each ranking; the last one is no better


@dataclass
class Contest:
    """A ranking that only leads to a better base."""

    bench: object
    base: FittedModel
    placed: object
    done: object

    def ranking(self) -> rank.Ranking:
        level = next(k for k, each in enumerate(LEVELS) if each < self.base.held_out.chi2 + 0.1)
        return rank.Ranking(model(LEVELS[level + 1]), ())


@pytest.mark.parametrize(("most", "left"), [(0, 10.0), (1, 4.0), (3, 1.5), (9, 1.5)])
def test_a_base_that_became_better_is_ranked_beside_so_often_at_most(
    monkeypatch: pytest.MonkeyPatch, most: int, left: float
) -> None:
    monkeypatch.setattr(rank, "_Contest", Contest)
    bench = cast(Any, SimpleNamespace(evidence=evidence_settings(rerankings=most)))
    found = rank.rank(bench, model(LEVELS[0]), (), lambda _: None)
    assert found.base.held_out.chi2 == pytest.approx(left, rel=0.1)
