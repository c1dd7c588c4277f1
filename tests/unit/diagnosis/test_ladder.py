from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fit_and_score
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.climb import Climb, _with_rung, climb
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.pruning import Pruned, finished, lean, prune
from dr_lab.diagnosis.search.rank import Ranking
from dr_lab.diagnosis.search.restack import reconsider
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.catalogue import SpecialCases
from dr_lab.effects.effect import Effect, place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log

THREE = ("coulomb_friction", "constant_offset", "actuator_delay")
FOUR = (*THREE, "quadratic_drag")
SITES = {"asymmetric_friction": "hinge", "base_tilt": "world", "coulomb_friction": "hinge"}
TOLERANCE = 1e-3  # of the cost; beside friction that is missing a fit creeps on from kink to kink at a thousandth
SURE = (("confidence", 0.99999), ("least_named", 1.0))  # beside friction a constant torque is then in doubt


def rubbing(torque: float, offset: float) -> list[Log]:
    """Logs of a pendulum with dry friction and a constant torque that its model lacks."""

    def push(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = offset - torque * np.tanh(data.qvel[0] / 1e-3)

    return [swinging(f"log_{k}", pendulum().nominal(), k, force=push, seconds=2.0) for k in range(3)]


def bench_of(logs: list[Log], model: Model, **asked: float) -> Bench:
    windows = windows_of(model, logs[:2]), windows_of(model, logs[2:])
    return Bench(*windows, solver_settings(tolerance=TOLERANCE), evidence_settings(**asked), 1)


@cache
def climbed(*names: str, most: int = 3, asked: tuple[tuple[str, float], ...] = ()) -> Ladder:
    """The ladder of logs with friction and a constant torque."""
    model, logs = pendulum(), rubbing(0.05, 0.1)
    bench, compiled = bench_of(logs, model, **dict(asked)), model.nominal()
    base = fit_and_score(bench, model, model.space.nominal)
    effects: dict[str, Effect] = {name: catalogue_effect(name) for name in names}
    scales = machine_scales(compiled, logs[:2], 0.03)
    heard = Heard()
    ladder = climb(Climb.begun(bench, base), effects, scales, compiled, most=most, watch=heard)
    assert [len(labels) for labels in heard.labels] == list(range(1, len(ladder.rungs))) or ladder.refuted
    assert not ladder.steps or heard.chi2[-1] == (ladder.base.held_out.chi2, ladder.models[-1].held_out.chi2)
    return ladder


class Heard(Silence):
    """What is told of a climb."""

    def __init__(self) -> None:
        self.labels, self.chi2 = list[list[str]](), list[tuple[float, float]]()

    def found(self, labels: Sequence[str], before: float, after: float) -> None:
        self.labels.append([*labels])
        self.chi2.append((before, after))


def labels(ladder: Ladder) -> list[list[str]]:
    return [[e.label for e in m.model.effects] for m in ladder.models]


def test_two_missing_effects_are_two_rungs_and_the_third_stops() -> None:
    ladder = climbed(*THREE)
    assert labels(ladder)[0] == []
    assert set(labels(ladder)[-1]) == {"coulomb_friction@hinge", "constant_offset@hinge"}
    assert len(ladder.steps) == 2
    assert ladder.rungs[-1].verdict.effects == ()
    chi2 = [m.held_out.chi2 for m in ladder.models]
    assert chi2[0] > chi2[1] > chi2[2]
    assert chi2[2] < 1.2
    values = ladder.models[-1].model.space.mapping(ladder.models[-1].fit.z)
    np.testing.assert_allclose(values["constant_offset@hinge.torque"], 0.1, rtol=0.03)
    np.testing.assert_allclose(values["coulomb_friction@hinge.torque"], 0.05, rtol=0.06)


@pytest.mark.slow
def test_what_another_missing_effect_leaves_in_doubt_is_added_on_trial_and_stays() -> None:
    ladder = climbed("coulomb_friction", "constant_offset", asked=SURE)
    first, second, _ = (rung.verdict for rung in ladder.rungs)
    assert (first.kind, first.effects, first.trial) == ("unexplained", (), ("constant_offset@hinge",))
    assert "constant_offset@hinge is worth a trial, which dr-lab close makes as far as `most` allows." in first.reason
    assert second.effects == ("coulomb_friction@hinge",)
    assert labels(ladder)[-1] == ["constant_offset@hinge", "coulomb_friction@hinge"]
    assert all(step.proven for step in ladder.steps)
    assert ladder.verdict(evidence_settings()) == "named"


@pytest.mark.slow
@pytest.mark.parametrize("most", [1, 3])
def test_what_stays_in_doubt_is_dropped_in_the_end(most: int) -> None:
    ladder = climbed("constant_offset", most=most, asked=SURE)
    assert ladder.rungs[0].verdict.trial == ("constant_offset@hinge",)
    assert ladder.steps == ()
    assert ladder.dropped == ("constant_offset@hinge",)
    assert ladder.verdict(evidence_settings()) == "unexplained"


def test_one_ranking_adds_nothing_on_trial() -> None:
    ladder = climbed("constant_offset", most=0, asked=SURE).with_first_step()
    assert ladder.steps == ()
    assert ladder.verdict(evidence_settings()) == "unexplained"


def test_where_the_fit_logs_score_no_model_has_logs_apart() -> None:
    model, logs = pendulum(), rubbing(0.05, 0.1)[:1]
    windows = windows_of(model, logs)
    bench = Bench(windows, windows, solver_settings(), evidence_settings(), 1)
    base, compiled = fit_and_score(bench, model, model.space.nominal), model.nominal()
    effects = {"constant_offset": catalogue_effect("constant_offset")}
    scales = machine_scales(compiled, logs, 0.03)
    ladder = climb(Climb.begun(bench, base), effects, scales, compiled, most=0, watch=Silence())
    assert not any(found.apart for found in (base, *(c.fitted_model for c in ladder.rungs[0].ranking)))


@pytest.mark.slow
def test_no_more_effects_are_added_than_allowed() -> None:
    ladder = climbed("coulomb_friction", "constant_offset", most=1)
    assert len(ladder.steps) == 1
    assert len(ladder.rungs) == 2


def test_a_rival_that_is_added_later_is_no_rival_any_more() -> None:
    ladder = climbed(*THREE)
    first, second = ladder.steps
    added = second.fitted_model.model.effects[-1].label
    rival = next(c for c in ladder.rungs[0].ranking if c.effect.label == added)
    logs = rubbing(0.05, 0.1)
    bench = bench_of(logs, pendulum())
    steps = reconsider(bench, ladder.base, (AddedEffect(first.fitted_model, (rival,)), second), [0])
    assert steps[0].rivals == ()
    assert steps[-1] is second


def test_what_explains_more_than_a_rival_may_yet_take_the_place_though_it_was_beaten() -> None:
    """A comparison of like with like is sure of a small difference, which what is still missing may have made."""
    judged = climbed(*THREE).rungs[0]
    ranking = tuple(
        replace(c, final=True, resolved=True, gain=replace(c.gain, total=gain))
        for c, gain in zip(judged.ranking, (100.0, 80.0, 50.0), strict=True)
    )
    first, second, third = ranking
    status = dict(zip((c.effect.label for c in ranking), ("equivalent", "rejected", "equivalent"), strict=True))
    verdict = replace(judged.verdict, effects=(first.effect.label, third.effect.label), status=status)
    step = replace(judged, ranking=ranking, verdict=verdict).step()
    assert [c.effect.label for c in step.rivals] == [third.effect.label]
    assert [c.effect.label for c in step.passed] == [second.effect.label]
    assert step.without(step.passed[0]).alternatives == step.rivals
    alone = replace(verdict, effects=(first.effect.label,))
    assert replace(judged, ranking=ranking, verdict=alone).step().passed == ()


@pytest.mark.parametrize(("dropped", "left"), [((), 1), (("quadratic_drag@hinge",), 0)])
def test_rivals_are_judged_anew_where_an_effect_beside_them_was_dropped(
    monkeypatch: pytest.MonkeyPatch, dropped: tuple[str, ...], left: int
) -> None:
    """Beside an effect that did its work a delay seemed as good as what is missing; beside the others it is not."""
    known = climbed(*THREE)
    first, second = known.steps
    delay = next(c for c in known.rungs[1].ranking if c.effect.effect.name == "actuator_delay")
    steps = (first, replace(second, rivals=(delay,)))
    monkeypatch.setattr("dr_lab.diagnosis.search.climb.finished", lambda *_: Pruned(steps, dropped))
    bench, compiled = bench_of(rubbing(0.05, 0.1), pendulum()), pendulum().nominal()
    cases = SpecialCases({}, machine_scales(compiled, rubbing(0.05, 0.1)[:2], 0.03), compiled)
    ranking = Ranking(known.models[-1], known.rungs[-1].ranking)
    found, over = _with_rung(Deletions(bench), replace(known, steps=steps), ranking, cases, most=3)
    assert over
    assert [len(step.rivals) for step in found.steps] == [0, left]


@pytest.mark.slow
@pytest.mark.parametrize("beaten", [False, True])
def test_a_better_rival_takes_the_place_and_what_follows_stands_on_it(beaten: bool) -> None:
    bench, ladder = bench_of(rubbing(0.05, 0.1), pendulum()), climbed(*FOUR, most=1)
    ranking = (replace(c, fitted_model=explain_on(bench, ladder.base, c)) for c in ladder.rungs[0].ranking)
    found = {c.effect.effect.name: c for c in ranking}
    kept, wrong, right = (found[name] for name in ("constant_offset", "quadratic_drag", "coulomb_friction"))
    # the drag came first, with friction as its rival; then the offset, with the delay as its rival
    second = explain_on(bench, wrong.fitted_model, kept)
    rivals, passed = ((), (right,)) if beaten else ((right,), ())
    steps = (AddedEffect(wrong.fitted_model, rivals, passed=passed), AddedEffect(second, (found["actuator_delay"],)))
    steps = (*steps, AddedEffect(explain_on(bench, second, found["actuator_delay"]), ()))
    better = reconsider(bench, ladder.base, steps, range(2))
    stacked = [[e.label for e in step.fitted_model.model.effects] for step in better]
    assert stacked[0] == [right.effect.label]
    assert stacked[1] == [right.effect.label, kept.effect.label]
    assert [len(labels) for labels in stacked] == [1, 2, 3]
    assert better[-1].fitted_model.held_out.chi2 < steps[-1].fitted_model.held_out.chi2
    assert better[0].alternatives == better[1].alternatives == ()


def explain_on(bench: Bench, below: FittedModel, candidate: Candidate) -> FittedModel:
    model = below.model.with_effect(candidate.effect)
    return fit_and_score(bench, model, np.append(below.fit.z, [p.nominal for p in candidate.effect.parameters]))


@pytest.mark.slow
def test_what_later_effects_made_superfluous_is_dropped() -> None:
    bench, ladder = bench_of(rubbing(0.05, 0.1), pendulum()), climbed(*FOUR, most=1)
    drag, friction, offset = (
        next(c for c in ladder.rungs[0].ranking if c.effect.effect.name == name)
        for name in ("quadratic_drag", "coulomb_friction", "constant_offset")
    )
    second = explain_on(bench, drag.fitted_model, friction)
    steps = tuple(AddedEffect(e, ()) for e in (drag.fitted_model, second, explain_on(bench, second, offset)))
    found = prune(Deletions(bench), ladder.base, steps, supported)
    kept, dropped = found.steps, found.dropped
    assert dropped == ("quadratic_drag@hinge",)
    assert [s.fitted_model.model.effects[-1].label for s in kept] == ["coulomb_friction@hinge", "constant_offset@hinge"]
    assert kept[-1].fitted_model.held_out.chi2 < 1.2
    assert prune(Deletions(bench), ladder.base, kept, supported) == Pruned(kept)


@pytest.mark.slow
def test_asymmetric_friction_beside_a_tilt_that_was_missing_is_put_back_to_coulomb_friction() -> None:
    """The richer kind came first, with the tilt as its asymmetry."""
    model, logs = pendulum(), rubbing(0.05, 0.0)
    scales = machine_scales(model.nominal(), logs[:2], 0.03)
    cases = SpecialCases({name: catalogue_effect(name) for name in SITES}, scales, model.nominal())
    richer, tilt, friction = (place(cases.effects[n], cases.compiled, at, scales) for n, at in SITES.items())
    true = model.with_effect(friction).with_effect(tilt)
    machine = true.compile(true.space.vector({f"{friction.label}.torque": 0.05, f"{tilt.label}.about_y": 0.04}))
    bench = bench_of([swinging(f"log_{k}", machine, k, seconds=2.0) for k in range(3)], model)
    base = fit_and_score(bench, model, model.space.nominal)
    first = model.with_effect(richer)
    begin = first.space.vector({f"{richer.label}.mean": 0.04})
    skewed = fit_and_score(bench, first, begin)
    second = fit_and_score(bench, first.with_effect(tilt), np.append(skewed.fit.z, 0.0), skewed.fit.delta)
    found = lean(Deletions(bench), base, (AddedEffect(skewed, ()), AddedEffect(second, ())), cases)
    assert [s.effect.label for s in found.steps] == [friction.label, tilt.label]
    assert found.dropped == ()
    (back,) = found.put_back
    assert (back.richer, back.poorer) == (richer.label, friction.label)
    value, std = back.further["asymmetry"]
    assert abs(value) < 3 * std
    values = found.steps[-1].fitted_model.values()
    np.testing.assert_allclose(values[f"{friction.label}.torque"], 0.05, rtol=0.05)
    np.testing.assert_allclose(values[f"{tilt.label}.about_y"], 0.04, rtol=0.05)
    assert finished(Deletions(bench), base, found.steps, cases) == Pruned(found.steps)
