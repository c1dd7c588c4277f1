"""KL(p‖q) between randomizers: in closed form where there is one, else by Monte Carlo."""

import torch
from numpy.random import Generator
from torch import Tensor
from torch.distributions import Distribution, MultivariateNormal, kl_divergence
from torch.distributions.kl import register_kl

from dr_lab.randomizers.histogram import Histogram
from dr_lab.randomizers.randomizer import Density
from dr_lab.randomizers.uniform import UniformBox


def divergence(p: Density, q: Density, samples: int, rng: Generator) -> Tensor:
    """KL(p‖q) = E_p[log p(z) − log q(z)] in nats, differentiable in the parameters of q.

    Closed forms: uniform and discrete to discrete, uniform, discrete and Gaussian to Gaussian, and those of torch.
    By Monte Carlo the value is differentiable in q alone.

    Args:
        p: where the expectation is taken.
        q: the other.
        samples: draws from p where there is no closed form.
        rng: stream of those draws.
    """
    closed = _closed_form(p.distribution(), q.distribution())
    if closed is not None:
        return closed
    z = torch.from_numpy(p.sample([rng] * samples))
    return (p.log_prob(z).detach() - q.log_prob(z)).mean()


def _closed_form(first: Distribution | None, second: Distribution | None) -> Tensor | None:
    """KL(first‖second), or None where it has no closed form, which torch's table of them says by an exception."""
    if first is None or second is None:
        return None
    try:
        return kl_divergence(first, second)
    except NotImplementedError:
        return None


@register_kl(Histogram, Histogram)
def _kl_histogram_histogram(p: Histogram, q: Histogram) -> Tensor:
    """Σ P (log P − log Q) on the same grid; others have no simple form."""
    same = p.logits.shape == q.logits.shape and torch.equal(p.low, q.low) and torch.equal(p.high, q.high)
    if not same:
        raise NotImplementedError("KL between histograms on different grids")  # read by `_closed_form`
    return (p.log_probabilities.exp() * (p.log_probabilities - q.log_probabilities)).sum()


@register_kl(UniformBox, Histogram)
def _kl_box_histogram(p: UniformBox, q: Histogram) -> Tensor:
    """−log vol(box) − Σ_c s_c (log Q(c) − log v): s_c is the share of the box in cell c; ∞ if it leaves the grid."""
    if bool((p.low < q.low).any() | (p.high > q.high).any()):
        return torch.tensor(torch.inf, dtype=q.low.dtype)
    share = torch.ones((), dtype=q.low.dtype)
    for axis, bins in enumerate(q.logits.shape):
        edges = q.low[axis] + torch.arange(bins + 1, dtype=q.low.dtype) * q.cell[axis]
        overlap = (torch.minimum(edges[1:], p.high[axis]) - torch.maximum(edges[:-1], p.low[axis])).clamp(min=0)
        share = share[..., None] * overlap / (p.high[axis] - p.low[axis])
    density = q.log_probabilities - q.cell.log().sum()
    return -p.entropy() - (share * density).sum()


@register_kl(UniformBox, MultivariateNormal)
def _kl_box_gaussian(p: UniformBox, q: MultivariateNormal) -> Tensor:
    return -p.entropy() - _expected_log_density(p.mean, torch.diag(p.variance), q)


@register_kl(Histogram, MultivariateNormal)
def _kl_histogram_gaussian(p: Histogram, q: MultivariateNormal) -> Tensor:
    return -p.entropy() - _expected_log_density(p.mean, p.covariance_matrix, q)


def _expected_log_density(mean: Tensor, covariance: Tensor, q: MultivariateNormal) -> Tensor:
    """E_p[log q(z)] of a Gaussian q under any p with this mean and covariance: log q(m) − ½ tr(Σ_q⁻¹ C)."""
    spread = torch.cholesky_solve(covariance, q.scale_tril).diagonal().sum()
    return q.log_prob(mean) - spread / 2
