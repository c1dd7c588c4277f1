"""Every algorithm learns on any device as it does on the CPU, and what it leaves is read on either."""

from pathlib import Path

import pytest
import torch
from small_runs import BATCH, RUNS, learnt, plan, resumed, tensors, trained

from dr_lab.collectors.boundary import DeviceBoundary
from dr_lab.training.plan import CHECKPOINT
from dr_lab.training.policy_snapshots import PolicySnapshots

CUDA = "cuda"
needs_cuda = pytest.mark.skipif(not torch.cuda.is_available(), reason="torch sees no CUDA device here")
# On the CPU alone, first weights that differ by a ten-millionth move such a trust-region step by 7e-4, a tenth of it.
# `learned_rate` compares MAML's gradients, `trpo` such steps.
SENSITIVE = ("maml", "meta_adr")
DEVICES = ["cpu", pytest.param(CUDA, marks=needs_cuda)]


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("run", RUNS)
def test_a_resumed_run_equals_an_uninterrupted_one(run: str, device: str, tmp_path: Path) -> None:
    whole = trained(run, device, tmp_path / "whole", 6 * BATCH)
    trained(run, device, tmp_path / "cut", 2 * BATCH)
    on = resumed(run, device, tmp_path / "cut" / CHECKPOINT, 6 * BATCH)
    assert whole.trainer.frames == on.trainer.frames
    found = learnt(on)
    for name, value in learnt(whole).items():
        assert torch.equal(value, found[name]), name


@pytest.mark.parametrize("run", ["ppo", "ddpg", "didor", "maml", "lsdr"])
def test_copies_act_as_the_policies_themselves_would(run: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = learnt(trained(run, "cpu", tmp_path / "plain", 3 * BATCH))
    monkeypatch.setattr("dr_lab.training.plan.boundary_to", DeviceBoundary)
    copied = learnt(trained(run, "cpu", tmp_path / "copied", 3 * BATCH))
    for name, value in plain.items():
        assert torch.equal(value, copied[name]), name


@needs_cuda
@pytest.mark.parametrize("run", [run for run in RUNS if run not in SENSITIVE])
def test_learns_what_it_learns_on_the_cpu(run: str, tmp_path: Path) -> None:
    here, there = (learnt(trained(run, device, tmp_path / device, BATCH)) for device in ("cpu", CUDA))
    for name, value in here.items():
        torch.testing.assert_close(there[name], value, rtol=1e-3, atol=1e-4, msg=lambda text, of=name: f"{of}: {text}")


@needs_cuda
@pytest.mark.parametrize("run", RUNS)
def test_networks_are_on_the_device_and_act_on_the_cpu(run: str, tmp_path: Path) -> None:
    training = trained(run, CUDA, tmp_path, BATCH)
    for policy in training.algorithm.policies.values():
        assert isinstance(policy, torch.nn.Module)
        assert {value.device.type for value in policy.parameters()} == {CUDA}
    snapshots = PolicySnapshots(training.algorithm, 1)
    snapshots.take(BATCH)
    assert {value.device.type for _, value in tensors(snapshots.state_dict())} == {"cpu"}
    observation = torch.zeros(4, plan(run, "cpu").env.make(None, 1, 0).episodes.observation.shape[1])
    (restored,) = snapshots.restored()
    for policy in (training.experience.policy, restored.exploring, restored.deployed):
        assert policy(observation).device.type == "cpu"


@needs_cuda
@pytest.mark.parametrize(("first", "second"), [("cpu", CUDA), (CUDA, "cpu")])
@pytest.mark.parametrize("run", RUNS)
def test_goes_on_on_another_device(run: str, first: str, second: str, tmp_path: Path) -> None:
    before = trained(run, first, tmp_path, 2 * BATCH)
    unmoved = plan(run, second).assemble(None)
    unmoved.trainer.resume(tmp_path / CHECKPOINT)
    found = learnt(unmoved)
    for name, value in learnt(before).items():
        assert torch.equal(value, found[name]), name
    on = resumed(run, second, tmp_path / CHECKPOINT, 4 * BATCH)
    assert on.trainer.frames >= 4 * BATCH
