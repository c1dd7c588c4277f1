from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_machines import NOISE, experiment_settings, formal_std, solver_settings, windows_settings
from effect_machines import block, placed

from dr_lab.diagnosis.experiment import play, readings
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.next_experiment.clearance import Clearance
from dr_lab.diagnosis.next_experiment.family import Bounds
from dr_lab.diagnosis.next_experiment.limits import Limits
from dr_lab.diagnosis.next_experiment.machine import Contender, ExperimentMachine
from dr_lab.diagnosis.next_experiment.propose import Proposal, Refusal, separate, sharpen
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.next_experiment.sizes import Sizes
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Log, MeasurementSet, Noise, Signal

LIMIT = 6.0  # N
WINDOWS = windows_settings(seconds=3.6)


def contender(effect: str, *values: float, site: str = "rail", std: float = 0.0) -> Contender:
    """A block on a rail with one effect at the given values."""
    model = block().with_effect(placed(block(), effect, site))
    return Contender(model, np.array(values), np.eye(len(values)) * std**2)


def machine(model: Contender, way: float = 0.5, speed: float = 2.0, low: float = -LIMIT) -> ExperimentMachine:
    """The rail, of which an experiment may use `way` m to either side."""
    kept = Limits(
        low=np.array([-way]),
        high=np.array([way]),
        speed=np.array([speed]),
        force=np.array([[-LIMIT], [LIMIT]]),
        certain=np.array([True]),
        distance=np.zeros(0),
    )
    return ExperimentMachine(
        start=np.zeros(1),
        names=("drive",),
        bounds=Bounds(np.array([max(low, 0.0)]), np.array([low]), np.array([LIMIT]), np.array([np.inf])),
        kept=kept,
        clearance=Clearance(model.model, model.z, 0.04),
        noise={"rail.position": Noise(NOISE, "m", "given")},
        windows=WINDOWS,
        solver=solver_settings(),
        command_rate=100.0,
        sample_rate=250.0,
        longest_window=0.4,
        threads=1,
    )


def settings(**changes: object) -> ExperimentSettings:
    small = {"population": 6, "generations": 1, "simulations": 200, "durations": [3.0], **changes}
    return experiment_settings(**small)


COULOMB, VISCOUS = contender("coulomb_friction", 1.0), contender("viscous_friction", 0.8)


def proposed(found: object) -> Proposal:
    assert isinstance(found, Proposal)
    return found


@cache
def deciding() -> Proposal:
    return proposed(separate(COULOMB, VISCOUS, machine(COULOMB), settings()))


def test_the_proposed_experiment_decides() -> None:
    rail, found = machine(COULOMB), deciding()
    assert found.sigma is not None
    time = np.arange(0.0, found.duration, 1 / 250)
    shown = readings(COULOMB.model, COULOMB.z, rail.start, found.commands, ["rail.position"], time)
    value = shown["rail.position"][:, 0] + NOISE * np.random.default_rng(0).normal(size=len(time))
    log = Log("played", {"rail.position": Signal("rail.position", "m", time, value)}, found.commands)
    measured = MeasurementSet("played", (log,), (), rail.noise, {"rail.position": 0.1})
    costs = []
    for each in (COULOMB, VISCOUS):
        windows = cut([log], measured, each.model.nominal(), WINDOWS)
        costs.append(Fitter(Replay(each.model, windows, 1), rail.solver).run(each.z).cost)
    missed = costs[1] - costs[0]
    assert missed > 25  # five standard deviations
    assert missed > 0.5 * found.sigma**2


def test_it_starts_and_ends_with_what_holds_the_machine_and_keeps_its_limits() -> None:
    rail, found = machine(COULOMB), deciding()
    command = found.commands["drive"]
    assert (command.value[0], command.value[-1]) == (0.0, 0.0)
    assert np.abs(command.value).max() <= LIMIT
    assert np.abs(np.diff(command.value)).max() < LIMIT / 2  # no jump
    assert command.time[-1] == pytest.approx(3.0)
    for each in (COULOMB, VISCOUS):
        tape = play(each.model, each.z[None], rail.start, [found.commands], found.duration).tape
        assert np.abs(tape.qpos).max() <= 0.5
        assert np.abs(tape.qvel).max() <= 2.0
    assert found.taken <= 1


@pytest.mark.slow
def test_it_keeps_its_limits_in_contexts_that_the_fit_does_not_exclude() -> None:
    unsure = [replace(each, covariance=np.eye(1) * 0.2**2) for each in (COULOMB, VISCOUS)]
    found = proposed(separate(unsure[0], unsure[1], machine(COULOMB), settings()))
    generator = np.random.default_rng(5)
    for each in unsure:
        z = each.drawn(8, 1.0, generator)
        tape = play(each.model, z, np.zeros(1), [found.commands], found.duration).tape
        assert np.abs(tape.qpos).max() <= 0.5 / 0.85  # the reserve is for this


@pytest.mark.slow
def test_the_same_seed_proposes_the_same() -> None:
    again = proposed(separate(COULOMB, VISCOUS, machine(COULOMB), settings()))
    assert np.array_equal(again.commands["drive"].value, deciding().commands["drive"].value)


@pytest.mark.slow
def test_what_is_the_same_to_every_experiment_is_not_separated() -> None:
    """A constant force along a horizontal rail and a rail that is not level."""
    offset, tilt = contender("constant_offset", 0.5), placed(block(), "base_tilt", "world")
    values = np.zeros(len(tilt.parameters))
    values[0] = 0.5 / (2 * 9.81)
    found = proposed(
        separate(offset, contender("base_tilt", *values, site="world"), machine(offset, way=9.0), settings())
    )
    assert found.sigma is not None
    assert found.sigma < 5


def test_where_the_machine_runs_away_by_itself_the_limit_is_told() -> None:
    """A force of 4 N that no command makes up for moves 2 kg by 4 m in 2 s, and the command must not fall below 0."""
    pushed = contender("constant_offset", 4.0)
    found = separate(
        pushed, contender("viscous_friction", 0.0), machine(pushed, low=0.0), settings(durations=[3.0, 2.0])
    )
    assert isinstance(found, Refusal)
    assert found.reason == "the range of rail"


@pytest.mark.slow
def test_an_experiment_that_no_refit_can_simulate_is_not_proposed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dr_lab.diagnosis.next_experiment.aims.missed", lambda *_: -np.inf)
    found = separate(COULOMB, VISCOUS, machine(COULOMB), settings(refitted=2))
    assert found == Refusal("a stable simulation")


@pytest.mark.slow
def test_a_shorter_experiment_is_tried_where_none_is_possible() -> None:
    """A drift by 0.05 N of 2 kg: 0.11 m in 3 s, 0.03 m in 1.5 s."""
    drifting = contender("constant_offset", 0.05)
    rail = machine(drifting, way=0.08, low=0.0)
    found = proposed(separate(drifting, contender("viscous_friction", 0.1), rail, settings(durations=[3.0, 1.5])))
    assert found.duration == 1.5


@pytest.mark.parametrize(("duration", "rate"), [(0.4, 1.0), (1.0, 1.0), (0.05, 100.0)])
def test_a_time_without_room_for_commands_or_a_window_is_refused(duration: float, rate: float) -> None:
    slow = replace(machine(COULOMB), command_rate=rate)
    found = separate(COULOMB, VISCOUS, slow, settings(durations=[duration]))
    assert isinstance(found, Refusal)
    assert "too little time" in found.reason


@pytest.mark.slow
def test_an_experiment_sharpens_what_is_poorly_known() -> None:
    """The linear forecast of a friction's standard deviation is what a fit to the experiment's log then has."""
    unsure = contender("coulomb_friction", 1.0, std=0.5)
    found = proposed(sharpen(unsure, machine(unsure, way=2.0), settings()))
    (row,) = found.sharpened
    assert (row.parameter, row.unit, row.before) == ("coulomb_friction@rail.torque", "N", pytest.approx(0.5))
    time = np.arange(0.0, found.duration, 1 / 250)
    shown = readings(unsure.model, unsure.z, np.zeros(1), found.commands, ["rail.position"], time)
    log = Log(
        "played", {"rail.position": Signal("rail.position", "m", time, shown["rail.position"][:, 0])}, found.commands
    )
    measured = MeasurementSet("played", (log,), (), machine(unsure).noise, {"rail.position": 0.1})
    windows = cut([log], measured, unsure.model.nominal(), windows_settings())
    fit = Fitter(Replay(unsure.model, windows, 1), solver_settings()).run(unsure.z)
    (std,) = formal_std(unsure.model, fit)
    assert row.after == pytest.approx(std, rel=0.3)
    assert row.after < 0.05


def test_what_is_well_known_is_not_sharpened() -> None:
    assert sharpen(contender("coulomb_friction", 1.0, std=1e-4), machine(COULOMB), settings()) is None


@pytest.mark.slow
def test_the_command_uses_a_range_that_is_not_symmetric() -> None:
    found = proposed(separate(COULOMB, VISCOUS, machine(COULOMB, way=50.0, speed=50.0, low=1.0), settings()))
    value = found.commands["drive"].value
    assert value.min() >= 1.0
    assert value.max() <= LIMIT
    assert np.ptp(value) > 0.1


@pytest.mark.parametrize(("key", "value"), [("durations", []), ("durations", [0.0]), ("poor", 0.0), ("population", 0)])
def test_settings_without_meaning_are_refused(key: str, value: object) -> None:
    with pytest.raises(ConfigError, match=key):
        settings(**{key: value})


def test_the_first_experiments_hold_simple_shapes() -> None:
    """Slow sines, fast sines and steps, all about the middle and as large as the family goes."""
    family = settings().family
    genes = family.draw(60, 1, np.random.default_rng(0))
    time = np.arange(601) / 100
    slow, fast, steps = family.commands(genes, time, machine(COULOMB).bounds)[::2, 0].reshape(10, 3, -1).swapaxes(0, 1)
    for shapes in (slow, fast, steps):
        assert np.abs(shapes).max(axis=1) == pytest.approx(LIMIT)
    assert np.abs(np.diff(fast)).mean() > 3 * np.abs(np.diff(slow)).mean()
    assert (np.abs(steps) > 0.9 * LIMIT).mean() > 2 * (np.abs(slow) > 0.9 * LIMIT).mean()


def test_steps_do_not_jump() -> None:
    family = settings().family
    genes = np.ones((1, 1, family.genes))
    command = family.commands(genes, np.arange(301) / 100, machine(COULOMB).bounds)[0, 0]
    assert np.abs(np.diff(command)).max() < LIMIT


@pytest.mark.parametrize("seconds", [1.5, 3.0, 6.0])
def test_fast_commands_follow_one_another_by_less_than_a_third_of_their_range(seconds: float) -> None:
    family = settings().family
    genes = family.draw(400, 1, np.random.default_rng(0))
    commands = family.commands(genes, np.arange(round(100 * seconds) + 1) / 100, machine(COULOMB).bounds)[:, 0]
    assert (np.abs(np.diff(commands)).max(axis=1) < np.ptp(commands, axis=1) / 3).all()


def test_sizes_grow_to_the_limit_and_shrink_to_it() -> None:
    """Where the share of the limit grows as the size, as its square, and not at all below a threshold."""
    laws = np.array([0.1, 3.0, 50.0]), np.array([1.0, 2.0, 1.0])
    sizes = Sizes(3, settings().sizing)
    for _ in range(6):
        sizes.seen(laws[0] * sizes.next ** laws[1])
    taken = laws[0] * sizes.kept ** laws[1]
    assert (taken <= 1).all()
    assert (taken > 0.9).all()


def test_a_size_that_is_not_to_be_passed_is_kept() -> None:
    sizes = Sizes(2, settings().sizing)
    sizes.most[0] = 1.0
    for _ in range(5):
        sizes.seen(0.2 * sizes.next)
    assert sizes.kept[0] == 1.0
    assert sizes.kept[1] > 4.6


@pytest.mark.slow
def test_the_largest_motion_is_tried() -> None:
    """A weak drive's worth grows with its size: the experiment takes most of what it may."""
    found = proposed(separate(COULOMB, VISCOUS, machine(COULOMB, way=0.3), settings()))
    assert found.taken > 0.6
