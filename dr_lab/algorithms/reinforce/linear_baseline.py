"""A ridge regression of returns-to-go on features of observation and time."""

import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.bounds import Positive, require_bounds


class LinearBaseline(Baseline):
    """b = w·f(o, t) with f = (o, o², τ, τ², τ³, 1), τ = t/`horizon`; w minimises mean (G − w·f)² + λ|w|².

    Even episodes get the w of the odd ones, and the other way round; a single one gets 0.

    Source: Duan et al. 2016, "Benchmarking deep reinforcement learning for continuous control", §5.

    Args:
        ridge: λ.
        horizon: control steps that make τ = 1.

    Raises:
        ConfigError: a number is not above 0.
    """

    def __init__(self, ridge: Positive, horizon: Positive) -> None:
        self.ridge, self.horizon = ridge, horizon
        require_bounds(self, "algorithm.baseline", LinearBaseline)

    def __call__(self, episodes: WholeEpisodes, to_go: Tensor) -> Tensor:
        """Each half by the regression on the other."""
        features, wanted = self._features(episodes.observation.double()), to_go.double()
        result = torch.zeros_like(wanted)
        for half in (0, 1) if len(wanted) > 1 else ():
            other = slice(1 - half, None, 2)
            weights = self._fitted(features[other], wanted[other], episodes.mask[other].double())
            result[half::2] = features[half::2] @ weights
        return result.to(to_go.dtype)

    def _features(self, observation: Tensor) -> Tensor:
        steps = torch.arange(observation.shape[1], dtype=observation.dtype, device=observation.device)
        time = steps / self.horizon
        powers = torch.stack([time, time**2, time**3, torch.ones_like(time)], -1)
        return torch.cat([observation, observation**2, powers.expand(len(observation), -1, -1)], -1)

    def _fitted(self, features: Tensor, wanted: Tensor, mask: Tensor) -> Tensor:
        rows, share = features.flatten(0, 1), (mask / mask.sum().clamp(min=1.0)).flatten()
        weighted = (rows * share[:, None]).T
        ridge = self.ridge * torch.eye(rows.shape[1], dtype=rows.dtype, device=rows.device)
        return torch.linalg.solve(weighted @ rows + ridge, weighted @ torch.where(share > 0, wanted.flatten(), 0.0))
