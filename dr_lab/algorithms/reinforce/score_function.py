"""The score-function estimator of the policy gradient, that of single episodes, and the surrogate it belongs to."""

from collections.abc import Mapping

import torch
from torch import Tensor
from torch.func import grad, vmap

from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.networks.gaussian_actor import GaussianActor

_TOGETHER = 20_000  # control steps whose gradients are worked out at once, which bounds the memory that they take


def score(parameters: Mapping[str, Tensor], actor: GaussianActor, episodes: WholeEpisodes, advantage: Tensor) -> Tensor:
    """(1/k) Σ_i Σ_t log π(u_t|o_t) A_t, whose gradient estimates that of the expected return.

    It does so without bias where A_t = G_t − b_t with γ = 1; with γ < 1 later states count as much as the first, as
    usual.

    Source: Williams 1992.

    Args:
        parameters: of π, as ``dict(actor.named_parameters())`` names and shapes them.
        actor: π.
        episodes: k of them.
        advantage: A, shape (k, t).
    """
    log_prob = actor.distribution(parameters, episodes.observation).log_prob(episodes.action)
    return (log_prob * advantage * episodes.mask).sum() / len(advantage)


def episode_gradients(actor: GaussianActor, episodes: WholeEpisodes, advantage: Tensor) -> Tensor:
    """Gradient of each episode's `score` by all of the policy's parameters in turn, shape (k, p).

    Args: as `score`, at the policy's own parameters, in the precision of the advantage.
    """
    parameters = {name: value.detach().to(advantage.dtype) for name, value in actor.named_parameters()}

    def of_one(episode: WholeEpisodes, weight: Tensor) -> dict[str, Tensor]:
        rows = WholeEpisodes(*(field[None] for field in episode))
        return grad(score)(parameters, actor, rows, weight[None])

    slopes = vmap(of_one, chunk_size=max(1, _TOGETHER // advantage.shape[1]))(episodes, advantage)
    return torch.cat([slope.flatten(1) for slope in slopes.values()], 1)


def gains(parameters: Mapping[str, Tensor], actor: GaussianActor, episodes: WholeEpisodes, advantage: Tensor) -> Tensor:
    """Σ_t (ρ_t − 1) A_t of each episode with ρ_t = π_θ(u_t|o_t)/π(u_t|o_t), shape (k,): what θ would gain in return.

    Its mean has the gradient of `score` at the policy's own parameters. Its curvature is that of the return but for
    what another policy would change in the states that are met; in episodes of one step it is that of the return.

    Source: Kakade, Langford 2002; Schulman et al. 2015, equation 3.

    Args: as `score`.
    """
    present = {name: value.detach().to(advantage.dtype) for name, value in actor.named_parameters()}
    own = actor.distribution(present, episodes.observation)
    log_prob = actor.distribution(parameters, episodes.observation).log_prob(episodes.action)
    ratio = (log_prob - own.log_prob(episodes.action)).exp()
    return ((ratio - 1.0) * advantage * episodes.mask).sum(1)
