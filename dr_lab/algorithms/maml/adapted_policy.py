"""What acts after an adaptation, as a function of the parameters that it begins with."""

from collections.abc import Mapping

import torch
from tensordict import TensorDict
from torch import Tensor
from torch.func import vjp

from dr_lab.algorithms.maml.linearised_update import LinearisedPolicy, LinearisedUpdate
from dr_lab.algorithms.maml.loss import MAMLLoss, meta_batch
from dr_lab.networks.flat import parts_of
from dr_lab.networks.gaussian import Gaussian

_ACTOR, _RATE = "actor.", "rate."


class AdaptedPolicy:
    """The policies of `MAMLLoss.policy` in a meta-batch; fulfils `PolicyAt`.

    Args:
        loss: says how they follow.
        like: θ and what is learnt of α, as `MAMLLoss.policy` names them, in the order of the vector.
        batch: the meta-batch.
    """

    def __init__(self, loss: MAMLLoss, like: Mapping[str, Tensor], batch: TensorDict) -> None:
        self._loss, self._like, self._batch = loss, like, batch

    def __call__(self, vector: Tensor) -> Gaussian:
        """The policies, μ of shape (T, R, nu), log σ of shape (T, 1, nu)."""
        return self._loss.policy(parts_of(vector, self._like), self._batch)

    @torch.no_grad()
    def linearised(self, vector: Tensor) -> "LinearisedAdaptation":
        """The same in the vicinity of the parameters."""
        return LinearisedAdaptation(self._loss, parts_of(vector, self._like), self._batch)

    def thinned(self, every: int) -> "AdaptedPolicy":
        """The same by and in fewer rows of each phase."""
        phases = [*self._loss.rows_before(self._batch), self._loss.rows_after(self._batch)]
        return AdaptedPolicy(self._loss, self._like, meta_batch([rows.thinned(every) for rows in phases]))


class LinearisedAdaptation:
    """J v and Jᵀ s through all updates, written out; fulfils `Linearised`.

    With u_0 = v, u_{j+1} = (1 − α ∘ H_j) u_j − dα ∘ g_j, where g_j and H_j are gradient and Hessian of the inner loss
    before update j + 1, J v is what the policies after the last make of u. Jᵀ goes the same way back. With first order,
    H is left out.

    Args:
        loss: says how the policies follow.
        parameters: θ and what is learnt of α, as `MAMLLoss.policy` names them.
        batch: the meta-batch.
    """

    def __init__(self, loss: MAMLLoss, parameters: Mapping[str, Tensor], batch: TensorDict) -> None:
        adaptation = loss.adaptation
        self._like, self._tasks, self._curved = parameters, len(batch), adaptation.order == 2
        self._rate, self._own_rates = adaptation.rate.of, _part(parameters, _RATE)
        theta, self._rates = loss.split(parameters)
        moved, self._updates = adaptation.beginning(theta, self._tasks), list[LinearisedUpdate]()
        for rows in loss.rows_before(batch):
            update = LinearisedUpdate(adaptation.actor, adaptation.loss, moved, rows)
            moved = {name: value - self._rates[name] * update.gradient[name] for name, value in moved.items()}
            self._updates.append(update)
        self._acting = LinearisedPolicy(adaptation.actor, moved, loss.rows_after(batch).observation)

    @property
    def policy(self) -> Gaussian:
        """What acts after the last update."""
        return self._acting.policy

    @torch.no_grad()
    def pushed(self, direction: Tensor) -> Gaussian:
        """J v."""
        parts = parts_of(direction, self._like)
        along = {name: value.expand(self._tasks, *value.shape) for name, value in _part(parts, _ACTOR).items()}
        scaled = self._rate(_part(parts, _RATE)) if self._own_rates else {}  # it is linear
        for update in self._updates:
            change = update.curved(along) if self._curved else {}
            along = {name: value - self._rates[name] * change.get(name, 0.0) for name, value in along.items()}
            for name, value in scaled.items():
                along[name] = along[name] - value * update.gradient[name]
        return self._acting.pushed(along)

    @torch.no_grad()
    def pulled(self, slope: Gaussian) -> Tensor:
        """Jᵀ s."""
        along = self._acting.pulled(slope)
        by_rate = dict.fromkeys(along, torch.zeros(()))
        for update in reversed(self._updates):
            by_rate = {name: by_rate[name] - (value * update.gradient[name]).sum(0) for name, value in along.items()}
            if self._curved:
                change = update.curved({name: self._rates[name] * value for name, value in along.items()})
                along = {name: value - change[name] for name, value in along.items()}
        found = {_ACTOR + name: value.sum(0) for name, value in along.items()}
        if self._own_rates:
            (own,) = vjp(self._rate, self._own_rates)[1](by_rate)
            found |= {_RATE + name: value for name, value in own.items()}
        return torch.cat([found[name].flatten() for name in self._like])


def _part(parameters: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}
