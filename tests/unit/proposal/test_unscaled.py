"""Which parameters are free where no known force gives the others their scale."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from played_logs import played, write_log

from dr_lab.__main__ import main

LINK = '<geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.01" mass="{1}"/>'
JOINT = '<joint name="{0}" axis="0 1 0" damping="0.002"/>'
ONE = f'<body name="a">{JOINT}{LINK}</body>'.format("q1", 0.4)
TWO = f'<body name="a">{JOINT}{LINK}'.format(
    "q1", 0.4
) + f'<body name="b" pos="0 0 -0.3">{JOINT}{LINK}</body></body>'.format("q2", 0.2)
APART = ONE + f'<body name="b" pos="0 1 0">{JOINT}{LINK}</body>'.format("q2", 0.2)
SPRUNG = ONE.replace("<joint", '<joint stiffness="0.5"')
MOTOR = '<actuator><motor name="u1" joint="q1" gear="1"/></actuator>'
MASS_SPRING = """<body name="a"><joint name="q1" type="slide" axis="1 0 0" stiffness="40" damping="0.3"/>
  <geom type="box" size="0.05 0.05 0.05" mass="0.5"/></body>"""


def machine(bodies: str, more: str = "") -> str:
    return (
        '<mujoco model="it"><compiler angle="radian"/><option timestep="0.001" integrator="RK4"/>'
        '<default><geom contype="0" conaffinity="0"/></default>'
        f"<worldbody>{bodies}</worldbody>{more}</mujoco>"
    )


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(mjcf: str, driven: Callable[[int], bool]) -> Mapping[str, Any]:
    """The free parameters that three logs lead to; the machine's links are as documented."""
    Path("it.xml").write_text(mjcf)
    joints, motors, paths = mjcf.count("<joint"), mjcf.count("<motor"), []
    for seed in range(3):
        levels = np.random.default_rng(seed).uniform(-0.4, 0.4, 50) * driven(seed)
        control = (lambda t, u=levels: [u[int(t / 0.1)]]) if motors else None
        start = [0.9 + 0.2 * seed, 0.5][:joints] if "slide" not in mjcf else [0.1 * (1 + seed)]
        time, place, controls = played(mjcf, start, 4.0, control, seed)
        names = ["t", *(f"q{j + 1}" for j in range(joints)), *(f"u{j + 1}" for j in range(motors))]
        paths.append(write_log(str(seed), ",".join(names), time, place, *([controls] if motors else [])))
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/model/it.yaml").read_text(encoding="utf-8"))["parameters"]


def never(_: int) -> bool:
    return False


def test_a_pendulum_that_swings_freely_has_its_centre_of_mass_free_and_not_its_mass() -> None:
    """Its period is that of (I + m l²) / m l, and no mass shows in it."""
    free = proposed(machine(ONE), never)
    assert [*free] == ["a.com", "q1.damping"]
    assert free["a.com"] == {"target": "body.a.ipos[2]", "unit": "m", "low": -0.3, "high": -0.075}
    page = " ".join(line.lstrip("# ") for line in Path("mine/model/it.yaml").read_text().splitlines())
    assert "a.mass stays as documented. No known force drives a, and one factor on all masses and dampings" in page
    assert "Free in its place is what sets the period: a.com." in page


def test_bounds_of_a_centre_of_mass_count_from_a_hinge_far_from_the_bodys_frame() -> None:
    """As exports of drawings have it: every frame at the origin of the world."""
    arm = """<body name="a"><inertial pos="0 0 1.2137" mass="0.2" diaginertia="2e-5 2e-5 2e-5"/>
      <joint name="q1" pos="0 0 1.2437" axis="0 1 0" damping="1e-4"/></body>"""
    free = proposed(machine(arm), never)
    assert free["a.com"] == {"target": "body.a.ipos[2]", "unit": "m", "low": 1.1837, "high": 1.2287}


@pytest.mark.parametrize(
    ("mjcf", "driven"),
    [
        (machine(SPRUNG), never),  # a spring of half the weight's moment
        (machine(MASS_SPRING), never),
        (machine(ONE, MOTOR), lambda seed: True),
        (machine(ONE, MOTOR), lambda seed: seed == 0),  # a motor that acts in one log of three
    ],
)
def test_a_mass_is_free_where_a_known_force_gives_it_its_scale(mjcf: str, driven: Callable[[int], bool]) -> None:
    assert [*proposed(mjcf, driven)] == ["a.mass", "q1.damping"]


def test_a_motor_whose_command_is_always_zero_gives_no_scale() -> None:
    assert [*proposed(machine(ONE, MOTOR), never)] == ["a.com", "q1.damping"]


def test_of_two_links_that_swing_freely_three_ratios_are_free() -> None:
    """Their motion knows I1 + m2 L², I2, m1 l1 + m2 L and m2 l2, of which one gives the others their scale."""
    free = [name for name in proposed(machine(TWO), never) if not name.endswith("damping")]
    assert len(free) == 3
    assert "a.mass" not in free
    assert {name.split(".")[0] for name in free} == {"a", "b"}


def test_a_motor_gives_no_scale_to_what_it_does_not_move() -> None:
    free = proposed(machine(APART, MOTOR), lambda seed: True)
    assert [*free] == ["a.mass", "b.com", "q1.damping", "q2.damping"]
