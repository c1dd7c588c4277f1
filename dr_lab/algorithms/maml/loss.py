"""The loss of a policy by what comes of it in some tasks after its adaptation to each."""

from collections.abc import Callable, Mapping, Sequence
from typing import cast

from tensordict import TensorDict, TensorDictBase
from tensordict.nn import TensorDictModule, TensorDictParams
from torch import Tensor, nn
from torchrl.objectives import LossModule

from dr_lab.algorithms.maml.adaptation import Adaptation, Parameters
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean_divergence
from dr_lab.networks.gaussian import Gaussian

OuterLoss = Callable[[Gaussian, PolicyRows], Tensor]


class MAMLLoss(LossModule):
    """L(θ, α) = mean over tasks i of L_outer(π_θᵢ, rows after), θᵢ = θ adapted on the rows before.

    A meta-batch is a tensordict of size [T], T tasks, which `meta_batch` lays out: under ``phase_0``, ``phase_1`` … are
    the fields of `PolicyRows`, of what was played before the first update, before the second, …, and after the last.

    Source: Finn et al. 2017, equation 4; the terms of the loss that come from what the phases before an update look
    like under another θ are left out, as there.

    Args:
        adaptation: from θ to θᵢ.
        outer: L_outer, a scalar.
    """

    actor_network: nn.Module
    actor_network_params: TensorDictParams
    target_actor_network_params: TensorDictParams
    rate_network: nn.Module
    rate_network_params: TensorDictParams
    target_rate_network_params: TensorDictParams

    def __init__(self, adaptation: Adaptation, outer: OuterLoss) -> None:
        super().__init__()
        self.adaptation, self.outer = adaptation, outer
        self._phases = [phase_key(k) for k in range(adaptation.updates + 1)]
        self.in_keys, self.out_keys = list(self._phases), ["loss_objective", "kl"]
        self.convert_to_functional(cast(TensorDictModule, adaptation.actor), "actor_network")  # any module is taken
        self.convert_to_functional(cast(TensorDictModule, adaptation.rate), "rate_network")
        self._actor_names = [name for name, _ in adaptation.actor.named_parameters()]
        self._rate_names = [name for name, _ in adaptation.rate.named_parameters()]

    def forward(self, tensordict: TensorDictBase) -> TensorDict:
        """``loss_objective``, and the divergence ``kl`` of what acted after the last update from what would act now."""
        policy = self.policy(self.functional_parameters(), tensordict)
        rows = self.rows_after(tensordict)
        return TensorDict({"loss_objective": self.outer(policy, rows), "kl": mean_divergence(policy, rows).detach()})

    def functional_parameters(self) -> dict[str, Tensor]:
        """Θ and α as `policy` takes them: the parameters of this module, of which a loss can be followed back to."""
        actor = {f"actor.{name}": _named(self.actor_network_params, name) for name in self._actor_names}
        return actor | {f"rate.{name}": _named(self.rate_network_params, name) for name in self._rate_names}

    def policy(self, parameters: Mapping[str, Tensor], tensordict: TensorDictBase) -> Gaussian:
        """What acts in the rows after the last update, μ of shape (T, R, nu), from θ and α; pure.

        Args:
            parameters: θ under ``actor.…``, what is learnt of α under ``rate.…``.
            tensordict: a meta-batch.
        """
        adapted = self.adaptation.adapted(*self.split(parameters), self.rows_before(tensordict))
        return self.adaptation.acting(adapted, self.rows_after(tensordict).observation)

    def rows_before(self, tensordict: TensorDictBase) -> list[PolicyRows]:
        """What was played before each update."""
        return [_rows(tensordict, key) for key in self._phases[:-1]]

    def rows_after(self, tensordict: TensorDictBase) -> PolicyRows:
        """What was played after the last update."""
        return _rows(tensordict, self._phases[-1])

    def split(self, parameters: Mapping[str, Tensor]) -> tuple[Parameters, Parameters]:
        """Θ and α of every parameter of the policy."""
        rates = {name: parameters[f"rate.{name}"] for name in self._rate_names}
        return {name: parameters[f"actor.{name}"] for name in self._actor_names}, self.adaptation.rate.of(rates)


def meta_batch(phases: Sequence[PolicyRows]) -> TensorDict:
    """Phases of T tasks in their order as the tensordict that `MAMLLoss` reads."""
    size = phases[0].weight.shape[:1]
    each = {phase_key(k): TensorDict(rows._asdict(), batch_size=size) for k, rows in enumerate(phases)}
    return TensorDict(each, batch_size=size)


def phase_key(k: int) -> str:
    """Where the rows are that were played after k updates."""
    return f"phase_{k}"


def _rows(tensordict: TensorDictBase, key: str) -> PolicyRows:
    return PolicyRows(*(cast(Tensor, tensordict[key, field]) for field in PolicyRows._fields))


def _named(parameters: TensorDictParams, name: str) -> Tensor:
    return cast(Tensor, parameters.get(tuple(name.split("."))))
