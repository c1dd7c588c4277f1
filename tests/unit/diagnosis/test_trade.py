from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from diagnosis_machines import evidence_settings, model_of
from effect_machines import placed

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.trade import Trade, trades
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.physics.model import Model

SETTINGS = evidence_settings()
PARAMETERS = {
    "block.mass": {"target": "body.block.mass", "unit": "kg", "low": 1.0, "high": 3.0},
    "rail.damping": {"target": "joint.rail.damping", "unit": "N·s/m", "low": 0.0, "high": 1.0},
}
BLOCK = """<mujoco model="block"><worldbody><body name="block">
  <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail"/></actuator></mujoco>"""


@dataclass(frozen=True)
class KnownFit:
    """A fit whose parameters are known to formal standard deviations."""

    z: np.ndarray
    equations: NormalEquations


def fitted(effect: str, site: str, z: list[float], std: list[float]) -> FittedModel:
    """The block with one effect, at values z known to standard deviations, both in the parameters' units."""
    plain: Model = model_of(BLOCK, PARAMETERS)
    model = plain.with_effect(placed(plain, effect, site))
    count = len(z)
    information = np.diag((model.space.span / np.array(std)) ** 2)
    nothing = np.zeros((1, 0))
    equations = NormalEquations(
        state=np.zeros((1, 0, 0)),
        mixed=np.zeros((1, 0, count)),
        state_gradient=nothing,
        parameter=information[None],
        parameter_gradient=np.zeros((1, count)),
        prior=np.full(count, 1e-9),
        prior_gradient=np.zeros(count),
    )
    unknown = cast(Any, None)
    return FittedModel(model, cast(Any, KnownFit(np.array(z), equations)), unknown, unknown)


def test_what_lies_farther_apart_than_the_evidence_asks_is_told() -> None:
    assert SETTINGS.threshold == 25  # five standard deviations
    offset = fitted("constant_offset", "rail", [2.0, 0.30, 0.1], [0.03, 0.003, 0.01])
    delay = fitted("actuator_delay", "drive", [2.2, 0.33, 0.004], [0.04, 0.004, 0.001])
    # mass: 0.2 / 0.05 = 4 standard deviations; damping: 0.03 / 0.005 = 6
    assert trades(offset, delay, SETTINGS) == (Trade("rail.damping", "N·s/m", 0.30, 0.33),)


def test_the_most_telling_comes_first() -> None:
    offset = fitted("constant_offset", "rail", [2.0, 0.30, 0.1], [0.003, 0.003, 0.01])
    delay = fitted("actuator_delay", "drive", [2.2, 0.33, 0.004], [0.004, 0.004, 0.001])
    assert [trade.name for trade in trades(offset, delay, SETTINGS)] == ["block.mass", "rail.damping"]


def test_effects_beside_which_nothing_moves_trade_nothing() -> None:
    offset = fitted("constant_offset", "rail", [2.0, 0.3, 0.1], [0.01, 0.01, 0.01])
    delay = fitted("actuator_delay", "drive", [2.0, 0.3, 0.004], [0.01, 0.01, 0.001])
    assert trades(offset, delay, SETTINGS) == ()
