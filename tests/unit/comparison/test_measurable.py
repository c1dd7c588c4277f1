"""What a scale tells of effects that no log tells apart."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from dr_lab.comparison.measurable import measurable
from dr_lab.physics.parameter import Parameter

DECLARED = (
    Parameter("fore.mass", "kg", 0.74, 0.3, 1.5),
    Parameter("upper.mass", "kg", 1.6, 0.8, 3.2),
    Parameter("elbow.damping", "N·m·s/rad", 0.05, 0.0, 1.0),
)


def model(label: str, values: tuple[float, float, float]) -> SimpleNamespace:
    named = dict(zip((p.name for p in DECLARED), values, strict=True))
    fitted = SimpleNamespace(model=SimpleNamespace(declared=DECLARED), values=lambda: named)
    return SimpleNamespace(fitted_model=fitted, effect=SimpleNamespace(label=label), rivals=())


@pytest.mark.parametrize(
    ("theirs", "told"),
    [
        pytest.param(
            (0.80, 1.50, 0.2), "`fore.mass` is 0.94 kg with `scale@one` and 0.8 kg with `scale@two`", id="mass"
        ),
        pytest.param((0.93, 1.49, 0.2), "", id="a damping, which no scale tells, and masses that hardly differ"),
    ],
)
def test_a_mass_that_rivals_ask_otherwise_of_is_to_be_weighed(theirs: tuple[float, float, float], told: str) -> None:
    ours, rival = model("scale@one", (0.94, 1.52, 0.05)), model("scale@two", theirs)
    ours.rivals = (rival,)
    notes = measurable(cast(Any, SimpleNamespace(steps=(ours,))))
    assert [told in note.message for note in notes] == ([True] if told else [])
    assert all("the model file says 0.74 kg" in note.message for note in notes)


def test_an_effect_without_rivals_needs_no_measurement() -> None:
    assert measurable(cast(Any, SimpleNamespace(steps=(model("scale@one", (0.94, 1.52, 0.05)),)))) == []
