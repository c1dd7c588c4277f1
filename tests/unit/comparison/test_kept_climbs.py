"""A climb that is interrupted goes on, with its windows' models as they were, to the end that it would have come to."""

import pickle
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import pytest
from diagnosis_machines import measured, pendulum, short_comparison, swinging
from effect_machines import catalogue_effect

from dr_lab.comparison.climbing import climbed
from dr_lab.comparison.kept_climbs import UNFINISHED, KeptClimbs
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.effects.effect import Effect
from dr_lab.errors import ConfigError, DataError

EFFECTS: dict[str, Effect] = {name: catalogue_effect(name) for name in ("coulomb_friction", "constant_offset")}


class Interrupting(Silence):
    """Is interrupted where the climb goes on for the first time."""

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        raise KeyboardInterrupt


class Counting(Silence):
    """Counts rankings and phases."""

    def __init__(self) -> None:
        self.counts, self.phases = list[int](), list[str]()

    def phase(self, text: str) -> None:
        self.phases.append(text)

    def ranking(self, labels: Sequence[str]):  # noqa: ANN201
        self.counts.append(len(labels))
        return super().ranking(labels)


def study(torque: float = 0.05) -> Study:
    """A pendulum beside logs of one that rubs, and that something pushes."""

    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = 0.1 - torque * np.tanh(data.qvel[0] / 1e-3)

    logs = [swinging(f"log_{k}", pendulum().nominal(), k, force=push, seconds=2.0) for k in range(3)]
    return prepare(short_comparison(pendulum(), measured(logs[:2], logs[2:])), lambda _: None)


def climbed_with(kept: KeptClimbs, watch: Silence, torque: float = 0.05) -> Ladder:
    return climbed(study(torque), EFFECTS, most=3, watch=watch, kept=kept)[1]


def told(ladder: Ladder) -> list[object]:
    """Everything of a ladder that a report tells, as numbers and names."""
    ranked = [[(c.effect.label, c.gain.total, c.predicted) for c in rung.ranking] for rung in ladder.rungs]
    models = [(m.fit.z.tolist(), m.fit.cost, m.held_out.chi2, [*m.values()]) for m in ladder.models]
    return [ranked, models, ladder.dropped, [s.effect.label for s in ladder.steps], ladder.laws, dict(ladder.refused)]


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("interrupted")
    with pytest.raises(KeyboardInterrupt):
        climbed_with(KeptClimbs(folder), Interrupting())
    return folder


def test_an_interrupted_climb_goes_on_to_the_same_end_and_ranks_nothing_twice(
    interrupted: Path, tmp_path: Path
) -> None:
    whole, rest = Counting(), Counting()
    expected = climbed_with(KeptClimbs(), whole)
    kept = KeptClimbs(tmp_path, interrupted)
    found = climbed_with(kept, rest)
    assert told(found) == told(expected)
    assert len(expected.steps) == 2
    assert rest.counts == whole.counts[1:]
    assert "Calibrating the model" in whole.phases
    assert "Calibrating the model" not in rest.phases
    again = Counting()
    assert told(climbed_with(KeptClimbs(None, tmp_path), again)) == told(expected)  # not climbed again
    assert again.counts == []
    kept.clear()
    assert not (tmp_path / UNFINISHED).exists()


def test_what_a_run_makes_anew_is_not_in_the_file_but_named(interrupted: Path, tmp_path: Path) -> None:
    made = study()
    found = KeptClimbs(tmp_path, interrupted).reached(made)
    assert found is not None
    assert found.climb is not None
    assert found.climb.deletions.bench is made.bench
    assert found.climb.ladder.base is found.base
    assert found.base.model is made.model
    assert found.climb.ladder.models[-1].model.spec is made.model.spec


def test_other_logs_are_refused(interrupted: Path) -> None:
    with pytest.raises(DataError, match=r"since then log log_0, log log_1, log log_2 changed\. Start"):
        climbed_with(KeptClimbs(None, interrupted), Silence(), torque=0.06)


def test_a_file_that_is_cut_short_is_refused(interrupted: Path, tmp_path: Path) -> None:
    (whole,) = (interrupted / UNFINISHED).iterdir()
    part = tmp_path / UNFINISHED / whole.name
    part.parent.mkdir()
    part.write_bytes(whole.read_bytes()[:-100])
    with pytest.raises(DataError, match=r"is damaged or cut short .* Start a new run, without resume"):
        climbed_with(KeptClimbs(None, tmp_path), Silence())


def test_a_file_that_would_run_something_is_refused(interrupted: Path, tmp_path: Path) -> None:
    (whole,) = (interrupted / UNFINISHED).iterdir()
    part, line = tmp_path / UNFINISHED / whole.name, whole.read_bytes().partition(b"\n")[0]
    part.parent.mkdir()
    part.write_bytes(line + b"\n" + pickle.dumps(print))
    with pytest.raises(DataError, match=r"it names builtins.print"):
        climbed_with(KeptClimbs(None, tmp_path), Silence())


def test_a_run_that_came_to_its_end_has_nothing_to_go_on_with(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"has nothing to go on with: it came to its end, which report\.md tells, or"):
        KeptClimbs(None, tmp_path)
