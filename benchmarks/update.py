"""How fast PPO learns from a batch: dr_lab's written-out loss beside TorchRL's, same networks, same minibatches.

    python benchmarks/update.py

Prints samples per second, the fastest of several rounds, which other work on the machine disturbs least.
"""

import argparse
import json
import time
from collections.abc import Sequence

import numpy as np
import torch

from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate
from dr_lab.algorithms.ppo.torchrl_surrogate import TorchRLSurrogate
from dr_lab.networks.adam import Adam, clip_norm
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser

OBSERVATION, ACTION = 11, 3  # Hopper
MINIBATCHES = (64, 256, 1024)


def surrogate(kind: type[Surrogate]) -> Surrogate:
    """PPO's loss on two networks of 64×64."""
    bound = np.ones(ACTION)
    actor = GaussianActor(OBSERVATION, -bound, bound, 0, NoNormaliser, [64, 64], "tanh", log_std=0.0)
    critic = Critic(OBSERVATION, 1, [64, 64], "tanh")
    return kind(actor, critic, clip=0.2, entropy_weight=0.0, critic_weight=0.5)


def samples(count: int) -> PolicySamples:
    """Random ones."""
    draw = torch.Generator().manual_seed(0)
    shapes = ((count, OBSERVATION), (count, ACTION), (count,), (count,), (count,))
    observation, action, log_prob, advantage, target = (torch.randn(shape, generator=draw) for shape in shapes)
    return PolicySamples(observation, action, log_prob - 4.0, advantage, target)


def rate(kind: type[Surrogate], minibatch: int, rounds: int) -> float:
    """Samples per second of loss, gradient, clipping and both optimisers' steps."""
    loss, batch = surrogate(kind), samples(8 * minibatch)
    parameters = (loss.actor_parameters, loss.critic_parameters)
    optimisers = [Adam(each, epsilon=1e-5) for each in parameters]
    best = float("inf")
    for _ in range(rounds):
        begin = time.perf_counter()
        for part in batch.minibatches(minibatch, torch.Generator().manual_seed(0)):
            loss.differentiate(part)
            clip_norm([each.gradient for each in parameters], 0.5)
            for optimiser in optimisers:
                optimiser.step(3e-4)
        best = min(best, time.perf_counter() - begin)
    return len(batch.target) / best


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=40)
    rounds = parser.parse_args(arguments).rounds
    torch.set_num_threads(1)
    figures: dict[str, float] = {}
    print(f"{'minibatch':>9} {'written out':>12} {'TorchRL':>12} {'ratio':>6}   samples/s")
    for size in MINIBATCHES:
        ours, theirs = (rate(kind, size, rounds) for kind in (ExplicitSurrogate, TorchRLSurrogate))
        figures |= {f"explicit_{size}": ours, f"torchrl_{size}": theirs, f"ratio_{size}": ours / theirs}
        print(f"{size:>9} {ours:>12.0f} {theirs:>12.0f} {ours / theirs:>6.2f}")
    print(json.dumps({name: round(value, 3) for name, value in figures.items()}))


if __name__ == "__main__":
    main()
