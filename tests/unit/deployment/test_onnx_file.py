"""The ONNX file acts as the policy of each kind of algorithm does, within the bounds of its actions."""

import json

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from small_runs import plan
from torch import Tensor

from dr_lab.deployment.onnx_file import Bounded, OnnxSettings, difference, onnx_of
from dr_lab.errors import ConfigError, DrLabError

SETTINGS = OnnxSettings(episodes=1, opset=18, tolerance=1e-4)
LOW, HIGH = np.array([-2.0, 0.0]), np.array([2.0, 1.0])
KINDS = ("ppo", "ddpg", "ensemble", "p2pdrl")  # others deploy what one of these does


def linear(observation: Tensor) -> Tensor:
    return observation[:, :2] * 3.0


def acted(file: bytes, observation: np.ndarray) -> np.ndarray:
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    rows = observation.astype(np.float32)[:, None]
    return np.concatenate([np.asarray(session.run(None, {"observation": row})[0]) for row in rows])


@pytest.fixture(scope="module")
def file() -> bytes:
    return onnx_of(Bounded(linear, LOW, HIGH), 3, json.dumps({"seconds": 0.01}), SETTINGS)


def test_actions_are_cut_off_at_their_bounds(file: bytes) -> None:
    seen = np.array([[0.1, 0.1, 0.0], [1.0, 1.0, 5.0], [-1.0, -1.0, 5.0]])
    assert acted(file, seen) == pytest.approx(np.array([[0.3, 0.3], [2.0, 1.0], [-2.0, 0.0]]))


def test_the_file_says_what_it_is(file: bytes) -> None:
    model = onnx.load_from_string(file)
    assert {entry.key: json.loads(entry.value) for entry in model.metadata_props} == {"dr_lab": {"seconds": 0.01}}
    assert [entry.version for entry in model.opset_import] == [18]


@pytest.mark.parametrize("run", KINDS)
def test_the_file_acts_as_what_the_algorithm_deploys(run: str) -> None:
    made = plan(run, "cpu")
    training, slots = made.assemble(None), made.env.make(None, 1, 0, 1).episodes
    policy = Bounded(training.algorithm.deployed, slots.low, slots.high)
    width = slots.observation.shape[1]
    seen = np.random.default_rng(0).normal(0.0, 2.0, (50, width))
    file = onnx_of(policy, width, "", SETTINGS)
    training.trainer.close()
    with torch.no_grad():
        expected = policy(torch.from_numpy(seen).float()).numpy()
    assert np.ptp(expected, axis=0).min() > 0
    assert acted(file, seen) == pytest.approx(expected, abs=1e-6)
    assert difference(file, policy, seen, SETTINGS) < 1e-6


def test_a_file_of_another_policy_is_refused(file: bytes) -> None:
    other = Bounded(lambda observation: linear(observation) + 0.1, LOW, HIGH)
    with pytest.raises(DrLabError, match=r"acts otherwise than the policy: by 0\.1 of the range"):
        difference(file, other, np.zeros((4, 3)), SETTINGS)


def test_operators_that_the_exporter_does_not_have_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"onnx\.opset is 3; .* wrote version 18"):
        onnx_of(Bounded(linear, LOW, HIGH), 3, "", OnnxSettings(episodes=1, opset=3, tolerance=1e-4))
