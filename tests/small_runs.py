"""Small training runs of every algorithm, on a device of one's choice."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import torch
from omegaconf import DictConfig
from torch import Tensor

from dr_lab.cli.arguments import arguments_of
from dr_lab.cli.compose import compose_from
from dr_lab.cli.folders import shipped
from dr_lab.experts.expert import Demonstrations, Expert
from dr_lab.training.plan import CHECKPOINT, Plan, Training

EPISODES, STEPS = 8, 10
BATCH = EPISODES * STEPS
COMMON = ["env=nav2d", f"env.task.time_limit={STEPS}", f"episodes={EPISODES}", "collector=lean", "threads=1"]
PPO = ["minibatch=16", "epochs=2", "actor.hidden=[8]", "critic.hidden=[8]"]
TEACHERS = [*(f"teachers.learner.{each}" for each in PPO)]
EMPIRICAL = ["randomizer=empirical"]
ADR = ["svpg.count=2", "svpg.proposals=2", "discriminator.hidden=[8]", "discriminator.minibatch=8"]
ADR = [f"distribution_learner.{each}" for each in ADR]
LSDR = ["randomizer=gaussian", "distribution_learner=lsdr", "distribution_learner.contexts=4", "rollout_episodes=4"]
SIMOPT = ["rollouts=1", "samples=4", "updates=1", "warm_up=0", f"every={BATCH}"]
SIMOPT = ["randomizer=gaussian", "distribution_learner=simopt", *(f"distribution_learner.{each}" for each in SIMOPT)]
SIMOPT = ["env=furuta", "target@distribution_learner.target=model", *SIMOPT]
OFF_POLICY = ["actor.hidden=[8]", "critic.hidden=[8]", "learning_starts=0", "minibatch=16", "steps_per_frame=0.1"]
MAML = ["algorithm=maml", "algorithm.tasks=2", "algorithm.actor.hidden=[8]"]
# What is overridden for each, of the algorithm unless it says more.
RUNS = {
    "ppo": ["algorithm=ppo", *(f"algorithm.{each}" for each in PPO)],
    "epopt": ["algorithm=epopt", "algorithm.warm_up=0.0", *(f"algorithm.{each}" for each in PPO)],
    "ddpg": ["algorithm=ddpg", *(f"algorithm.{each}" for each in OFF_POLICY)],
    "td3": ["algorithm=td3", *(f"algorithm.{each}" for each in OFF_POLICY)],
    "trpo": ["algorithm=trpo", "algorithm.actor.hidden=[8]"],
    "reinforce": ["algorithm=reinforce", "algorithm.actor.hidden=[8]"],
    "critic_baseline": ["algorithm=reinforce", "algorithm.actor.hidden=[8]", "baseline@algorithm.baseline=critic"],
    "maml": MAML,
    "learned_rate": [*MAML, "inner_rate@algorithm.adaptation.rate=learned", "policy_step@algorithm.step=clipped"],
    "didor": ["algorithm=didor", f"algorithm.teacher_frames={BATCH}", *(f"algorithm.{each}" for each in TEACHERS)],
    "ensemble": ["algorithm=ensemble", *(f"algorithm.{each}" for each in TEACHERS)],
    "p2pdrl": ["algorithm=p2pdrl", "algorithm.workers=2", *(f"algorithm.learner.{each}" for each in PPO)],
    "gail": [
        "algorithm=gail",
        "algorithm.expert.path=episodes.mcap",
        "algorithm.discriminator.gradient_penalty=10.0",
        *(f"algorithm.learner.{each}" for each in [*PPO, f"batch_frames={BATCH}"]),
    ],
    "lsdr": ["algorithm=ppo", *(f"algorithm.{each}" for each in PPO), *LSDR],
    "simopt": ["algorithm=ppo", *(f"algorithm.{each}" for each in PPO), *SIMOPT],
    "adr": ["algorithm=ppo", *(f"algorithm.{each}" for each in PPO), *EMPIRICAL, "distribution_learner=adr", *ADR],
    "meta_adr": [*MAML, *EMPIRICAL, "distribution_learner=meta_adr", *ADR],
}


class Walker(Expert):
    """Walks anywhere."""

    def demonstrations(self) -> Demonstrations:
        """Fifty control steps."""
        draw = torch.Generator().manual_seed(1)
        seen, done = torch.randn(51, 2, generator=draw), torch.rand(50, 2, generator=draw) * 0.2 - 0.1
        return Demonstrations.of([(seen, done)])


@cache
def _composed(*overrides: str) -> DictConfig:
    return compose_from((shipped(),), "train", overrides)


def plan(run: str, device: str, seed: int = 0, frames: int = 3 * BATCH) -> Plan:
    """A run by its name in `RUNS`."""
    batch = [] if run == "gail" else [f"algorithm.batch_frames={BATCH}"]
    every = [f"frames={frames}", f"checkpoint_every={BATCH}", f"seed={seed}", f"device={device}"]
    cfg = _composed(*COMMON, *every, *RUNS[run], *batch)
    found: Plan = arguments_of("train", cfg, (shipped(),), only=["plan"])[1]["plan"]
    return replace(found, algorithm=partial(found.algorithm, expert=Walker())) if run == "gail" else found


def trained(run: str, device: str, folder: Path, frames: int, seed: int = 0) -> Training:
    """What a run is after so many control steps, with its checkpoint in a folder."""
    training = plan(run, device, seed).assemble(folder / CHECKPOINT)
    training.trainer.run(frames, lambda *_: None)
    training.trainer.close()
    return training


def resumed(run: str, device: str, checkpoint: Path, frames: int) -> Training:
    """What a run is that went on from a checkpoint."""
    training = plan(run, device).assemble(None)
    training.trainer.resume(checkpoint)
    training.trainer.run(frames, lambda *_: None)
    training.trainer.close()
    return training


def tensors(state: object, name: str = "") -> Iterator[tuple[str, Tensor]]:
    """All tensors of a state, by where they are."""
    if isinstance(state, Tensor):
        yield name, state
    elif isinstance(state, Mapping):
        for key, value in state.items():
            yield from tensors(value, f"{name}.{key}")
    elif isinstance(state, list | tuple):
        for index, value in enumerate(state):
            yield from tensors(value, f"{name}.{index}")


def learnt(training: Training) -> dict[str, Any]:
    """All tensors of algorithm and learner, on the CPU."""
    state = {"algorithm": training.algorithm.state_dict(), "learner": training.learner.state_dict()}
    return {name: value.cpu() for name, value in tensors(state)}
