"""Logs that contradict a closed chain, and chains that come apart."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from slider_crank import MJCF, logs

from dr_lab.diagnosis.checks.firm_loops import firm_loops
from dr_lab.diagnosis.checks.open_chains import OpenChain, open_chain
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Log, Noise
from tests.diagnosis_machines import measured, model_check_settings, windows_settings

NOISE = {"crank.position": Noise(1e-3, "rad", "given"), "slider.position": Noise(1e-4, "m", "given")}


@cache
def closed() -> list[Log]:
    return logs("ab", seconds=3.0)


def crank(solref: str = "") -> Model:
    return from_spec("crank", mujoco.MjSpec.from_string(MJCF.format(solref)), {})


def read_as(log: Log, channel: str, sign: float, offset: float) -> Log:
    signal = log.outputs[channel]
    return replace(log, outputs={**log.outputs, channel: replace(signal, value=sign * signal.value + offset)})


def opened(found: list[Log]) -> OpenChain | None:
    return open_chain(crank().nominal(), found, NOISE, model_check_settings())


@pytest.mark.slow
def test_chains_that_are_closed_up_to_noise_are_not_told() -> None:
    assert opened(closed()) is None


@pytest.mark.slow
def test_a_crank_alone_contradicts_nothing() -> None:
    alone = [replace(log, outputs={"crank.position": log.outputs["crank.position"]}) for log in closed()]
    assert opened(alone) is None
    assert opened([read_as(log, "crank.position", -1, 0.4) for log in alone]) is None


@pytest.mark.parametrize(
    ("channel", "sign", "offset"),
    [("slider.position", 1, 0.4), ("slider.position", -1, 0.0), ("slider.position", -1, 0.4)],
)
def test_a_zero_and_a_direction_that_close_them_are_found(channel: str, sign: int, offset: float) -> None:
    found = opened([read_as(log, channel, sign, offset) for log in closed()])
    assert found is not None
    assert found.mending is not None
    assert (found.mending.channel, found.mending.sign) == (channel, sign)
    assert found.mending.offset == pytest.approx(-sign * offset, abs=1e-4)
    assert found.mending.left < 3e-4
    assert f"{channel} closes them" in found.message


def test_lengths_that_are_wrong_are_told_without_a_remedy() -> None:
    spec = mujoco.MjSpec.from_string(MJCF.format(""))
    spec.body("rod").pos = [0.15, 0.0, 0.0]
    spec.body("slider").pos = [0.45, 0.0, 0.0]
    found = open_chain(spec.compile(), closed(), NOISE, model_check_settings())
    assert found is not None
    assert found.mending is None
    assert "a length of the model" in found.message


def test_a_chain_whose_softness_nobody_chose_becomes_firm_and_is_told() -> None:
    model, data = crank(), measured(closed(), noise=1e-3)
    found = firm_loops(model, closed(), data, windows_settings(), model_check_settings(), 1)
    assert found.share > 1
    assert found.asked == 'solref="0.002 1" solimp="0.999 0.999"'
    assert list(found.model.spec.equalities[0].solref) == [0.002, 1.0]
    assert list(model.spec.equalities[0].solref) == [0.02, 1.0]
    assert "wrist come apart" in found.message
    given = crank('solref="0.05 1"')
    assert firm_loops(given, closed(), data, windows_settings(), model_check_settings(), 1).model is given


def test_what_draws_a_body_after_a_mocap_body_stays_soft() -> None:
    spec = mujoco.MjSpec.from_string(MJCF.format(""))
    hand = spec.worldbody.add_body(name="hand", mocap=True)
    spec.delete(spec.equalities[0])
    spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY, name1=hand.name, name2="slider")
    model = from_spec("drawn", spec, {})
    assert (
        firm_loops(model, closed(), measured(closed(), noise=1e-3), windows_settings(), model_check_settings(), 1).model
        is model
    )


def test_a_firm_chain_stays_closed_where_a_soft_one_opens() -> None:
    """It opens by the square of the time constant, and by (1 − d)/d of the impedance d."""
    worst = []
    for firmness in ("", 'solref="0.002 1"', 'solref="0.002 1" solimp="0.999 0.999"'):
        model = mujoco.MjModel.from_xml_string(MJCF.format(firmness))
        model.opt.integrator, data, gaps = mujoco.mjtIntegrator.mjINT_RK4, mujoco.MjData(model), []
        data.ctrl[0] = 0.5
        for _ in range(1000):
            mujoco.mj_step(model, data)
            gaps.append(np.linalg.norm(data.efc_pos))
        worst.append(max(gaps))
    assert worst[0] > 1e-3
    assert worst[1] < 0.1 * worst[0]
    assert worst[2] < 0.1 * worst[1]


def test_an_impedance_that_somebody_chose_stays() -> None:
    found = firm_loops(
        crank('solimp="0.95 0.99"'), closed(), measured(closed()), windows_settings(), model_check_settings(), 1
    )
    assert found.asked == 'solref="0.002 1"'
    assert list(found.model.spec.equalities[0].solimp[:2]) == [0.95, 0.99]
