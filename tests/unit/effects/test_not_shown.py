"""Effects that logs cannot show for what they lack: a command, or the place of a joint."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import clock
from effect_machines import block, catalogue_effect, hanging, placed, scales_of

from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.effects.effect import place
from dr_lab.errors import ModelError
from dr_lab.trajectory import Log, Signal


@pytest.mark.parametrize("name", ["actuator_delay", "torque_scale", "saturation", "dead_zone"])
def test_what_changes_a_command_needs_one_in_the_logs(name: str) -> None:
    known = scales_of(block())
    assert placed(block(), name, "drive", known)
    with pytest.raises(ModelError, match="No log holds the command of drive"):
        placed(block(), name, "drive", replace(known, uncommanded=frozenset({"drive"})))
    assert placed(block(), "coulomb_friction", "rail", replace(known, uncommanded=frozenset({"drive"})))


@pytest.mark.parametrize("commanded", [True, False])
def test_scales_tell_which_commands_no_log_holds(*, commanded: bool) -> None:
    model, time = block().nominal(), clock(500, 0.01)
    place_of = Signal("rail.position", "m", time, np.sin(time))
    commands = {"drive": Signal("drive", "1", time, np.cos(time))} if commanded else {}
    found = machine_scales(model, [Log("log", {"rail.position": place_of}, commands)], 0.03)
    assert found.uncommanded == (frozenset() if commanded else {"drive"})


@pytest.mark.parametrize("name", ["spring", "hardening_spring", "cogging", "position_dependent_friction"])
@pytest.mark.parametrize(
    ("turns", "unmeasured", "refused"), [(3.0, True, True), (0.5, True, False), (3.0, False, False)]
)
def test_what_acts_by_a_place_needs_a_joint_that_is_measured_or_only_swings(
    name: str, turns: float, unmeasured: bool, refused: bool
) -> None:
    model = hanging()
    scales = replace(
        scales_of(model, position=turns * 2 * np.pi), unmeasured=frozenset({"hinge"} if unmeasured else ())
    )

    def found() -> object:
        return place(catalogue_effect(name), model.nominal(), "hinge", scales)

    if refused:
        with pytest.raises(ModelError, match="No channel tells where the joint is"):
            found()
    else:
        assert found()
