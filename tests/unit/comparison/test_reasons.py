"""The reason of a ranking says what became of the effect that it names."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from dr_lab.comparison import entries
from dr_lab.comparison.ladder_report import reason_of
from dr_lab.diagnosis.evidence.trade import Trade

RICHER, POORER = "smooth_friction@arm", "coulomb_friction@arm"


@pytest.mark.parametrize(
    ("put_back", "dropped", "told"),
    [
        ((), (), "It explains much."),
        (
            (SimpleNamespace(richer=RICHER, poorer=POORER),),
            (),
            f"It explains much. It was put back to {POORER}; see the notes.",
        ),
        ((), (RICHER,), "It explains much. It was dropped again; see the notes."),
        ((SimpleNamespace(richer="cogging@arm", poorer=POORER),), ("cogging@arm",), "It explains much."),
    ],
)
def test_what_became_of_the_named_effect(put_back: tuple[object, ...], dropped: tuple[str, ...], told: str) -> None:
    rung = explaining(alike=False)
    ladder = SimpleNamespace(put_back=put_back, dropped=dropped, rungs=(rung,))
    assert reason_of(cast(Any, None), rung, cast(Any, ladder)) == told


def test_a_ranking_of_one_effect_at_other_sites_says_so() -> None:
    first, second = explaining(alike=True), explaining(alike=True)
    ladder = cast(Any, SimpleNamespace(put_back=(), dropped=(), rungs=(first, second)))
    assert reason_of(cast(Any, None), first, ladder) == "It explains much."
    assert reason_of(cast(Any, None), second, ladder).endswith(
        "Nothing but the effect named before was tried here, at other sites."
    )


def explaining(*, alike: bool) -> Any:  # noqa: ANN401 (a rung's double)
    verdict = SimpleNamespace(effects=(RICHER,), reason="It explains much.")
    return SimpleNamespace(ranking=(), alike=alike, verdict=verdict)


def test_what_makes_up_for_an_effect_differs_as_it_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    found = (Trade("arm.mass", "kg", 0.137812, 0.137851), Trade("arm.inertia_scale", "1", 0.9961, 0.99))
    monkeypatch.setattr(entries, "trades", lambda *_: found)
    bench = cast(Any, SimpleNamespace(evidence=None))
    assert entries.trade(RICHER, cast(Any, None), POORER, cast(Any, None), bench) == (
        f"{POORER} in place of {RICHER}: arm.mass 0.13785 instead of 0.13781 kg, "
        "arm.inertia_scale 0.99 instead of 0.9961."
    )
