"""Equivalence classes that are known beforehand, predicted from the truth."""

import functools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hydra.utils import instantiate
from strangers import needs_pinocchio

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.predicted import PredictedClasses
from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.errors import ConfigError
from dr_lab.plants.alike.actuator_rivals import lagged, powered, ramped
from dr_lab.plants.alike.classes import Classes
from dr_lab.plants.alike.course import mean_held
from dr_lab.plants.alike.friction_rivals import bent, gripped
from dr_lab.plants.alike.path import Path
from dr_lab.plants.alike.regression import remaining, without
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Choice
from dr_lab.plants.command import Command
from dr_lab.plants.rig import Rig

NOTHING = Signature(np.zeros((1, 1)), np.zeros((1, 2)))
SEEN = ["plant/instruments=tachometers", "plant.duration=0.8", "plant.peaks=[0.5]"]


@cache
def rule() -> Classes:
    return instantiate(compose("benchmark", ["benchmark=strangers"]).classes.rule)


def classes(*overrides: str, machine: str = "wheel", parts: int = 2) -> dict[str, dict[str, int]]:
    """By the rule as it is, or with fewer intervals between two commands, which do where nothing is late."""
    return replace(rule(), parts=parts).of(bench(*overrides, machine=machine), seed=5)


def left(*overrides: str, machine: str = "wheel") -> dict[str, float]:
    """χ² that each rival leaves of the only truth."""
    return replace(rule(), parts=2).regression(bench(*overrides, machine=machine), seed=5).left_by(0)


def bench(*overrides: str, machine: str) -> Rig:
    short = ["plant.duration=1.6", "plant.peaks=[0.5]"]
    return instantiate(compose("record", [f"plant=strangers/{machine}", *short, *overrides]).plant, _convert_="all")


def hidden(name: str, *numbers: str) -> list[str]:
    return [f"plant/hidden=general/{name}", *(f"plant.hidden.{number}" for number in numbers)]


def truth_label(truth: list[str]) -> str:
    name, site, *_ = truth
    return f"{name.rpartition('/')[2]}@{site.rpartition('=')[2]}"


@needs_pinocchio
@pytest.mark.slow
def test_friction_is_alone_in_its_class_for_what_generalises_it_claims_more() -> None:
    (known,) = classes(*hidden("coulomb_friction", "site=wheel", "torque=0.03")).values()
    assert known == {"coulomb_friction@wheel": 1}


@needs_pinocchio
@pytest.mark.parametrize(
    "truth",
    [
        hidden("saturation", "site=motor", "limit=0.267"),
        pytest.param(hidden("dead_zone", "site=motor", "width=0.028"), marks=pytest.mark.slow),
    ],
)
def test_an_effect_fits_its_own_logs_whose_peaks_differ(truth: list[str]) -> None:
    # A limit as a share of each log's own peak would be another limit in each, and leave a χ² of a million.
    known = left(*truth, "plant.peaks=[0.5,0.3]", "plant.duration=0.8")
    assert known[truth_label(truth)] < rule().threshold


@needs_pinocchio
def test_a_power_of_the_command_does_not_take_the_drive_away() -> None:
    # Without drive, and with masses and dampings free, a machine of no mass would lack nothing.
    known = left(*hidden("cogging", "site=wheel", "sine=0.04", "periods=9"))
    assert known["cogging@wheel"] < rule().threshold < 100 * rule().threshold < known["command_power@motor"]


@needs_pinocchio
@pytest.mark.parametrize(
    "truth",
    [
        hidden("coulomb_friction", "site=shoulder", "torque=0.2"),
        pytest.param(
            hidden("asymmetric_friction", "site=shoulder", "mean=0.15", "asymmetry=0.1"), marks=pytest.mark.slow
        ),
    ],
)
def test_dry_friction_bears_what_holds_a_joint(truth: list[str]) -> None:
    # The shoulder stands still at times; what friction bears there counted as missing, a χ² of thousands.
    known = left(*truth, "plant.duration=1.2", "plant.peaks=[2.2]", machine="elbow")
    assert known[truth_label(truth)] < rule().threshold < known["viscous_friction@shoulder"]


@needs_pinocchio
@pytest.mark.slow
def test_what_a_free_parameter_does_is_of_the_class_of_the_base() -> None:
    # Damping is free; mass and damping together are as good as another torque.
    for numbers in (["viscous_friction", "site=wheel", "coefficient=0.01"], ["torque_scale", "site=motor", "gain=0.8"]):
        (known,) = classes(*hidden(*numbers)).values()
        assert "base" in known


@needs_pinocchio
@pytest.mark.slow
def test_too_little_to_be_seen_is_of_the_class_of_the_base() -> None:
    (known,) = classes(*hidden("coulomb_friction", "site=wheel", "torque=1e-5")).values()
    assert "base" in known


@needs_pinocchio
@pytest.mark.parametrize(
    "truth",
    [
        pytest.param(hidden("command_power", "site=motor", "full=0.5"), marks=pytest.mark.slow),
        pytest.param(hidden("warming", "site=wheel", "cold=0.02", "constant=0.5"), marks=pytest.mark.slow),
        pytest.param(hidden("creeping_friction", "site=wheel", "torque=0.04", "creep=0.2"), marks=pytest.mark.slow),
        pytest.param(hidden("bending_friction", "site=wheel", "torque=0.04", "stiffness=4.0"), marks=pytest.mark.slow),
    ],
)
def test_powers_drifts_and_soft_friction_are_none_of_the_poorer_effects(truth: list[str]) -> None:
    ((label, known),) = classes(*truth).items()
    names = {member.partition("@")[0] for member in known}
    assert label in known
    assert names.isdisjoint({"base", "dead_zone", "saturation", "coulomb_friction", "viscous_friction"})


@pytest.mark.slow
@needs_pinocchio
def test_a_creep_that_is_too_slow_to_show_is_coulomb_friction() -> None:
    ((label, known),) = classes(*hidden("creeping_friction", "site=wheel", "torque=0.04", "creep=1e-3")).items()
    assert label == "smooth_friction@wheel"
    assert "coulomb_friction@wheel" in known


@pytest.mark.slow
@needs_pinocchio
def test_a_wrong_zero_is_a_leaning_base_to_a_wheel() -> None:
    (known,) = classes(*hidden("sensor_bias", "site=wheel", "bias=0.05")).values()
    assert {"sensor_bias@wheel", "base_tilt@world"} <= known.keys()
    assert known.keys().isdisjoint({"base", "coulomb_friction@wheel", "sensor_scale@wheel"})


@needs_pinocchio
@pytest.mark.parametrize(
    ("late", "shown"),
    [
        (hidden("actuator_delay", "site=motor", "delay=0.008"), "sensor_time_offset@wheel"),
        pytest.param(
            hidden("actuator_lag", "site=motor", "constant=0.004"), "sensor_low_pass@wheel", marks=pytest.mark.slow
        ),
    ],
)
def test_with_one_command_a_late_command_is_a_late_reading(late: list[str], shown: str) -> None:
    # A delay or a lag of the only input commutes with a motion that is linear, as the wheel's nearly is.
    ((truth, known),) = classes(*late).items()
    assert {truth, shown} <= known.keys()
    assert "base" not in known


@needs_pinocchio
@pytest.mark.slow
def test_a_late_command_of_a_slide_is_a_late_reading_between_two_delays_of_the_grid() -> None:
    # A slide's motion is linear, so the two are the same exactly; coarse intervals and grids told them apart.
    late = hidden("actuator_delay", "site=motor", "delay=0.009117")
    (known,) = classes(*late, machine="lift", parts=rule().parts).values()
    assert known == {"actuator_delay@motor": 1, "sensor_time_offset@lift": 1}


@needs_pinocchio
@pytest.mark.parametrize(("noise", "more"), [(0.02, set()), (20.0, {"base"})])
def test_late_velocities_beside_positions_in_time_are_a_filter(noise: float, more: set[str]) -> None:
    late = hidden("velocity_low_pass", "site=wheel", "constant=0.004")
    (known,) = classes(*late, *SEEN, f"plant.instruments.velocity.std={noise}").values()
    assert known.keys() == {"velocity_low_pass@wheel", *more}


@needs_pinocchio
def test_late_positions_are_a_filter_of_the_encoder() -> None:
    late = hidden("sensor_low_pass", "site=wheel", "constant=0.004")
    (known,) = classes(*late, *SEEN).values()
    assert "velocity_low_pass@wheel" not in known


@pytest.mark.slow
@needs_pinocchio
def test_a_centre_farther_out_is_a_payload_and_less_mass() -> None:
    # Mass, first and second moment of a link are three numbers; a payload with a free mass of the link moves all three.
    moved = hidden("centre_of_mass_offset", "site=forearm", "offset=[0.01,0.0,0.0]")
    (known,) = classes(*moved, machine="elbow").values()
    assert known.keys() == {"centre_of_mass_offset@forearm", "payload@forearm"}


def two(first: list[str], second: list[str]) -> list[str]:
    """Overrides that hide two general effects, each an option and its numbers."""
    made = ["plant/hidden=general/several"]
    for place, (name, *numbers) in (("a", first), ("b", second)):
        at = f"plant.hidden.effects.{place}"
        made += [f"+plant/hidden@{at}=general/{name}", *(f"{at}.{number}" for number in numbers)]
    return made


ELASTIC = ["joint_elasticity", "site=elbow", "rotor=0.002", "compliance=0.01", "damping=0.05"]


@needs_pinocchio
def test_beside_what_turns_inside_another_effect_has_its_own_class() -> None:
    # All of a machine with something inside counted as known, so that nothing else could be seen in it.
    friction = ["coulomb_friction", "site=shoulder", "torque=0.2"]
    known = classes(*two(ELASTIC, friction), "plant.duration=1.2", "plant.peaks=[2.2]", machine="elbow")
    assert known["coulomb_friction@shoulder"] == {"coulomb_friction@shoulder": 1}
    assert "base" not in known["joint_elasticity@elbow"]


@needs_pinocchio
def test_two_effects_that_turn_inside_are_refused() -> None:
    loose = ["flexible_mode", "site=shoulder", "inertia=0.01", "stiffness=10.0", "damping=0.01"]
    with pytest.raises(ConfigError, match="joint_elasticity@elbow, flexible_mode@shoulder"):
        classes(*two(ELASTIC, loose), machine="elbow")


def test_machines_whose_equations_are_written_out_are_refused_before_they_are_diagnosed() -> None:
    case = Case("pendulum", "single", "spring", "own", 1, ("plant=pendulum",), (), label="hung")
    arguments = functools.partial(compose_arguments, folders=(shipped(),))
    with pytest.raises(ConfigError, match=r"Case hung: .* Pendulum, whose equations .* Give classes=ranked"):
        PredictedClasses(rule()).require(case, arguments)


def test_a_filtered_path_is_that_of_the_closed_form() -> None:
    time, constant, pulse = np.linspace(0.0, 2.0, 2001), 0.004, 30.0
    shown = Path(time, np.sin(pulse * time)).filtered(constant)
    gain, lag = 1 / np.hypot(1, pulse * constant), np.arctan(pulse * constant)
    settled = time > 0.1
    np.testing.assert_allclose(shown.value[settled], gain * np.sin(pulse * time[settled] - lag), atol=1e-8)
    np.testing.assert_allclose(shown.at(np.array([1.0005])), gain * np.sin(pulse * 1.0005 - lag), atol=1e-8)


def test_commands_are_averaged_lagged_and_ramped_exactly() -> None:
    held = Command(np.array([0.0, 0.5]), np.array([1.0, 3.0]))
    np.testing.assert_allclose(mean_held(held, np.array([0.25, 0.75, 1.0])), [2.0, 3.0])
    mean, step = np.array([0.0, 1.0, 1.0]), np.full(3, 0.01)
    share = 1 - np.exp(-0.01 / 0.004)
    np.testing.assert_allclose(lagged(mean, step, 0.004), [0.0, 1 - 0.4 * share, 1 - 0.4 * share * (1 - share)])
    np.testing.assert_allclose(ramped(mean, step, 50.0), [0.0, 0.25, 0.75])
    np.testing.assert_allclose(bent(np.array([1.0, 1.0, -1.0]), np.ones(3), 1.5), [0.5, 1.25, 1.0])


def test_columns_are_regressed_out_and_bounds_kept() -> None:
    generator = np.random.default_rng(0)
    columns = generator.standard_normal((50, 4))
    gram = without(columns.T @ columns, [1])
    clean = columns - np.outer(columns[:, 1], columns[:, 1] @ columns / (columns[:, 1] @ columns[:, 1]))
    np.testing.assert_allclose(gram, clean.T @ clean, atol=1e-9)
    free = Choice([NOTHING, NOTHING], [-np.inf] * 2, [np.inf] * 2)
    fitted = np.linalg.lstsq(clean[:, 2:], -clean[:, 0])[1][0]
    assert remaining(gram, 0, 2, free) == pytest.approx(fitted, rel=1e-6)
    bound = Choice([NOTHING], [0.0], [0.0])
    assert remaining(gram, 0, 2, bound) == pytest.approx(gram[0, 0])


def test_powers_of_a_command_are_right_at_the_full_one() -> None:
    np.testing.assert_allclose(powered(np.array([-4.0, 0.0, 1.0, 4.0]), 4.0, 2.0), [-4.0, 0.0, 0.25, 4.0])


def test_bristles_follow_the_way_and_creep() -> None:
    """Dahl's exponential of the way without creep; the hyperbolic tangent of the speed without a way."""
    step, speed = np.full(200, 0.001), np.full(200, 2.0)
    gone = np.concatenate([[0.0], np.cumsum(speed * step)])
    bend = 1 - np.exp(-gone / 0.1)
    mean = 1 - 0.1 * np.diff(bend) / np.diff(gone)  # of each interval, in closed form
    np.testing.assert_allclose(gripped(speed, step, 0.1, np.tanh(speed / 1e-6)), mean, rtol=1e-9)
    np.testing.assert_allclose(gripped(speed, step, 0.0, np.tanh(speed)), np.tanh(speed))
