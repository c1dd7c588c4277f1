"""Notes on what knowledge of the machine may decide."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from effect_machines import block, placed

from dr_lab.comparison.knowledge_notes import changed_masses, richer_effects
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.physics.parameter import Parameter


def rung(status: dict[str, str]) -> Rung:
    """One whose effects, by name, have these statuses."""
    effects = {name: placed(block(), name, "rail") for name in status}
    labels = {effects[name].label: each for name, each in status.items()}
    named = tuple(label for label, each in labels.items() if each == "named")
    verdict = SimpleNamespace(effects=named, status=labels)
    ranking = [SimpleNamespace(effect=effect) for effect in effects.values()]
    return cast(Rung, SimpleNamespace(ranking=ranking, verdict=verdict))


def test_what_explains_as_much_with_more_parameters_is_told_but_for_richer_kinds_of_what_is_named() -> None:
    status = {
        "coulomb_friction": "named",
        "stribeck_friction": "not_needed",
        "flexible_mode": "not_needed",
        "spring": "rejected",
    }
    (note,) = richer_effects([rung(status)], set())
    assert note.message.startswith("flexible_mode@rail explains as much as coulomb_friction@rail, with more")
    assert not richer_effects([rung({"coulomb_friction": "named", "stribeck_friction": "not_needed"})], set())
    assert not richer_effects([rung(status)], {"coulomb_friction@rail"})


@pytest.mark.parametrize(
    ("value", "said"), [(1.0, ""), (1.3, ""), (1.5, "1.5 times"), (0.6, "0.6 times"), (2.0, ""), (0.5, "")]
)
def test_a_mass_that_ended_far_from_the_file_is_told(value: float, said: str) -> None:
    """A bound that binds is told elsewhere."""
    mass = Parameter("link.mass", "kg", 1.0, 0.5, 2.0)
    damping = Parameter("hinge.damping", "N·m·s/rad", 1.0, 0.5, 2.0)
    model = SimpleNamespace(inertials=(), declared=(mass, damping))
    last = SimpleNamespace(model=model, values=lambda: {"link.mass": value, "hinge.damping": 1.5})
    notes = changed_masses(cast(Any, last))
    assert bool(notes) == bool(said)
    assert all(said in note.message for note in notes)
