"""Products with the Hessian of the divergence from the policy that acted."""

import torch
from torch import Tensor
from torch.autograd import grad

from dr_lab.algorithms.trpo.conjugate_gradients import Product
from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.networks.gaussian import Gaussian


def divergence_product(policy: Gaussian, rows: PolicyRows, at: Tensor) -> Product:
    """The map v ↦ ∇²_θ E[KL(π_acted‖π_θ)] v at the parameters θ that acted, exactly.

    There KL and its slope by y = (μ, log σ) are 0, so that the Hessian is Jᵀ F J with J = ∂y/∂θ and
    F = ∇²_y KL = diag(1/σ², 2). J v is the derivative of u ↦ Jᵀ u, which is linear: both passes go back through graphs
    that are made once.

    Args:
        policy: π_θ, with a graph that leads to θ; that of the adapted policies leads through their adaptation.
        rows: what θ led to.
        at: θ, a leaf that requires a gradient, shape (p,).
    """
    outputs = (policy.mean, policy.log_std)
    probes = tuple(torch.zeros_like(output, requires_grad=True) for output in outputs)
    (back,) = grad(outputs, at, probes, create_graph=True)
    share = (rows.weight / rows.weight[..., 0].numel()).unsqueeze(-1)  # of a row in the mean over rows and tasks
    precision = share * (-2.0 * policy.log_std.detach()).exp()

    def product(vector: Tensor) -> Tensor:
        mean, log_std = grad(back, probes, vector, retain_graph=True)
        spread = (2.0 * share * log_std).expand(*share.shape[:-1], log_std.shape[-1]).sum_to_size(log_std.shape)
        (result,) = grad(outputs, at, (precision * mean, spread), retain_graph=True)
        return result

    return product
