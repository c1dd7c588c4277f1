"""Products with the Hessian of the divergence from the policy that acted."""

from torch import Tensor

from dr_lab.algorithms.trpo.conjugate_gradients import Product
from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.algorithms.trpo.policy_step import Linearised
from dr_lab.networks.gaussian import Gaussian


def divergence_product(near: Linearised, rows: PolicyRows) -> Product:
    """The map v ↦ ∇²_θ E[KL(π_acted‖π_θ)] v at the parameters θ that acted, exactly.

    There KL and its slope by y = (μ, log σ) are 0, so that the Hessian is Jᵀ F J with J = ∂y/∂θ and
    F = ∇²_y KL = diag(1/σ², 2).

    Args:
        near: π_θ and J.
        rows: what θ led to.
    """
    share = (rows.weight / rows.weight[..., 0].numel()).unsqueeze(-1)  # of a row in the mean over rows and tasks
    precision = share * (-2.0 * near.policy.log_std).exp()

    def product(vector: Tensor) -> Tensor:
        along = near.pushed(vector)
        width = along.log_std.shape
        spread = (2.0 * share * along.log_std).expand(*share.shape[:-1], width[-1]).sum_to_size(width)
        return near.pulled(Gaussian(precision * along.mean, spread))

    return product
