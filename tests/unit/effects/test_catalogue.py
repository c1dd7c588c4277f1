"""The catalogue on machines on which some effects cannot act."""

from dataclasses import replace

import mujoco
import pytest
from effect_machines import NAMES, block, catalogue_effect, placed, scales_of

from dr_lab.effects.catalogue import Candidates, candidates, require_names
from dr_lab.effects.effect import Scales, place
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.mjcf import mjcf
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.parameter import Parameter

EFFECTS = {name: catalogue_effect(name) for name in NAMES}
DELAYED = '<motor name="drive" joint="rail" delay="0.01" nsample="6"/>'


def found(model: Model) -> Candidates:
    return candidates(model, EFFECTS, scales_of(model), model.nominal())


def labels(model: Model) -> set[str]:
    return {one.label for one in found(model).placed}


def test_a_plain_machine_takes_all() -> None:
    assert not found(block()).refused
    assert {"actuator_delay@drive", "spring@rail", "payload@block"} <= labels(block())


def test_an_effect_that_a_model_holds_is_not_offered_again() -> None:
    model = block()
    held = place(EFFECTS["spring"], model.nominal(), "rail", scales_of(model))
    assert labels(model) - labels(model.with_effect(held)) == {"spring@rail"}


@pytest.mark.parametrize("name", ["constant_offset", "stribeck_friction", "payload", "cogging"])
def test_an_effect_that_the_file_of_an_earlier_run_holds_is_refused(name: str) -> None:
    site = "block" if name == "payload" else "rail"
    improved = block().with_effect(placed(block(), name, site))
    refused = found(from_spec("again", mujoco.MjSpec.from_string(mjcf(improved, improved.space.high)), {})).refused
    assert set(refused) == {f"{name}@{site}"}
    assert "The model's file has this effect already" in refused[f"{name}@{site}"]


def test_an_actuator_with_a_delay_takes_no_other() -> None:
    delayed = found(block(actuator=DELAYED))
    assert set(delayed.refused) == {"actuator_delay@drive"}
    assert "Take its delay out of the MJCF" in delayed.refused["actuator_delay@drive"]
    assert {one.label for one in delayed.placed} == labels(block()) - {"actuator_delay@drive"}


def test_a_springdamper_keeps_passive_forces_out() -> None:
    damped = found(block(joint='springdamper="0.5 1"'))
    assert {"spring@rail", "viscous_friction@rail", "coulomb_friction@rail"} <= set(damped.refused)
    assert all("springdamper" in reason for reason in damped.refused.values())
    assert {"actuator_delay@drive", "payload@block", "sensor_time_offset@rail"} <= {p.label for p in damped.placed}


def test_a_spring_that_yields_takes_no_other() -> None:
    yielding = found(block(joint='stiffness="2" springyield="0.05"')).refused
    assert set(yielding) == {"spring@rail", "hardening_spring@rail"}
    assert all("Take springyield out" in reason for reason in yielding.values())


def test_inertia_from_geometry_keeps_a_payload_out() -> None:
    xml = """<mujoco><compiler inertiafromgeom="true"/><worldbody><body name="ball">
      <joint name="hinge" axis="0 1 0"/><geom size="0.1" pos="0 0 -1"/></body></worldbody></mujoco>"""
    assert set(found(from_spec("ball", mujoco.MjSpec.from_string(xml), {})).refused) == {"payload@ball"}


@pytest.mark.parametrize("away", [0.0, 1.0, 3.0])  # m
def test_no_bounds_are_made_up_where_a_joint_is_unknown(away: float) -> None:
    known = scales_of(block())
    lowest, highest = ({joint: end + away for joint, end in ends.items()} for ends in (known.lowest, known.highest))
    scales = replace(known, lowest=lowest, highest=highest, unknown=frozenset({"rail"}))
    blind = candidates(block(), EFFECTS, scales, block().nominal())
    assert {"viscous_friction@rail", "coulomb_friction@rail", "spring@rail"} <= set(blind.refused)
    assert all("no channel measures rail" in reason for reason in blind.refused.values())
    assert {"armature@rail", "actuator_delay@drive", "payload@block"} <= {one.label for one in blind.placed}
    assert labels(block()) == {one.label for one in blind.placed} | set(blind.refused)


def test_effects_go_by_their_own_names() -> None:
    require_names(EFFECTS)
    with pytest.raises(
        ConfigError, match=r"effect/mine\.yaml builds the effect 'spring'\. Call it effect/spring\.yaml"
    ):
        require_names(EFFECTS | {"mine": EFFECTS["spring"]})


def test_an_effect_that_acts_in_no_part_is_refused() -> None:
    """A class of a user's own that forgets to derive from the part in which it acts."""

    class Idle(JointEffect):
        name, family, law, fingerprint = "idle", "friction", "", ""

        def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
            return (Parameter("size", "1", 0.0, 0.0, 1.0),)

    with pytest.raises(ModelError, match=r"'idle' does nothing.* Idle from one of SpecEdit"):
        place(Idle(), block().nominal(), "rail", scales_of(block()))
