"""MAML's loss: its gradient against closed forms and finite differences, of both orders, of one task and of many."""

from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.maml.adaptation import Adaptation
from dr_lab.algorithms.maml.adapted_policy import AdaptedPolicy
from dr_lab.algorithms.maml.inner_loss import ClippedLoss, InnerLoss, ScoreLoss
from dr_lab.algorithms.maml.inner_rate import FixedRate, LearnedRate
from dr_lab.algorithms.maml.loss import MAMLLoss, meta_batch
from dr_lab.algorithms.trpo.divergence_product import divergence_product
from dr_lab.algorithms.trpo.own_policy import AutogradLinearised
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean, mean_divergence, ratio
from dr_lab.errors import ConfigError
from dr_lab.networks.flat import parts_of
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.mlp import Activation
from dr_lab.networks.normaliser import NoNormaliser

RATE = 0.1


def actor(
    observation: int = 3, action: int = 2, hidden: list[int] | None = None, activation: Activation = "tanh"
) -> GaussianActor:
    bound = np.ones(action)
    layers = [6, 5] if hidden is None else hidden
    return GaussianActor(observation, -bound, bound, 0, NoNormaliser, layers, activation, log_std=-0.3).double()


def surrogate(policy: Gaussian, rows: PolicyRows) -> Tensor:
    return -mean(ratio(policy, rows) * rows.advantage, rows)


def loss_of(policy: GaussianActor, inner: InnerLoss, outer: Any = surrogate, **changes: Any) -> MAMLLoss:  # noqa: ANN401
    numbers: dict[str, Any] = {"rate": partial(FixedRate, rate=RATE), "updates": 1, "order": 2}
    return MAMLLoss(Adaptation(policy, inner, **numbers | changes), outer)


def draw(*shape: int, seed: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def phases(policy: GaussianActor, adaptation: Adaptation, tasks: int, rows: int = 12) -> list[PolicyRows]:
    """What adapted policies might have played: each phase's rows are of the policies that acted then."""
    theta = {name: value.detach() for name, value in policy.named_parameters()}
    rates = adaptation.rate.of({name: value.detach() for name, value in adaptation.rate.named_parameters()})
    parameters, found = adaptation.beginning(theta, tasks), list[PolicyRows]()
    for k in range(adaptation.updates + 1):
        if found:
            parameters = adaptation.updated(parameters, rates, found[-1])
        observation = draw(tasks, rows, 3, seed=10 * k)
        acted = adaptation.acting(parameters, observation)
        action = acted.mean + acted.log_std.exp() * draw(tasks, rows, 2, seed=10 * k + 1)
        weight = torch.full((tasks, rows), 1.0 / (rows - 2), dtype=torch.float64)
        weight[:, -2:] = 0.0
        found.append(
            PolicyRows(observation, action, *acted, draw(tasks, rows, seed=10 * k + 2), weight),
        )
    return found


def gradient(loss: MAMLLoss, batch: TensorDict) -> dict[str, Tensor]:
    parameters = {name: value.detach().requires_grad_() for name, value in loss.functional_parameters().items()}
    value = loss.outer(loss.policy(parameters, batch), loss.rows_after(batch))
    slopes = torch.autograd.grad(value, list(parameters.values()), materialize_grads=True)
    return dict(zip(parameters, slopes, strict=True))


def value_at(loss: MAMLLoss, batch: TensorDict, vector: Tensor, like: dict[str, Tensor]) -> float:
    return float(loss.outer(loss.policy(parts_of(vector, like), batch), loss.rows_after(batch)))


@pytest.mark.parametrize("updates", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("inner", [ScoreLoss(), ClippedLoss(0.3)])
@pytest.mark.parametrize("rate", [FixedRate, LearnedRate])
def test_the_gradient_of_second_order_is_that_of_finite_differences(
    inner: InnerLoss, updates: int, rate: type[FixedRate] | type[LearnedRate]
) -> None:
    policy = actor(hidden=[4, 3])
    loss = loss_of(policy, inner, updates=updates, rate=partial(rate, rate=RATE)).double()
    batch = meta_batch(phases(policy, loss.adaptation, tasks=3))
    like = {name: value.detach() for name, value in loss.functional_parameters().items()}
    vector = torch.cat([value.flatten() for value in like.values()])
    moved = vector + 1e-3 * draw(len(vector), seed=5)  # off the policy that acted, where min and clip have no kink
    at = {name: value.clone().requires_grad_() for name, value in parts_of(moved, like).items()}
    value = loss.outer(loss.policy(at, batch), loss.rows_after(batch))
    found = torch.cat([slope.flatten() for slope in torch.autograd.grad(value, list(at.values()))])
    size = 1e-6
    wanted = [
        (value_at(loss, batch, moved + size * unit, like) - value_at(loss, batch, moved - size * unit, like))
        / (2 * size)
        for unit in torch.eye(len(vector), dtype=torch.float64)
    ]
    wanted = torch.tensor(wanted, dtype=torch.float64)
    assert ((found - wanted).norm() / wanted.norm()).item() < 1e-6
    torch.testing.assert_close(found, wanted, rtol=1e-4, atol=1e-7)


@dataclass(frozen=True)
class Quadratic(InnerLoss):
    """½ E|μ − u|², whose minimum the action says."""

    def __call__(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        return 0.5 * mean(((policy.mean - rows.action) ** 2).sum(-1), rows)


def bias_rows(goal: list[float], advantage: float = 1.0) -> PolicyRows:
    """One row of each task in which nothing is observed, so that μ is the bias."""
    action = torch.tensor(goal, dtype=torch.float64)[:, None, None]
    one = torch.ones(len(goal), 1, dtype=torch.float64)
    return PolicyRows(
        torch.zeros_like(action), action, torch.zeros_like(action), torch.zeros_like(action), advantage * one, one
    )


@pytest.mark.parametrize("updates", [1, 3])
def test_the_gradient_of_a_quadratic_has_a_closed_form_and_that_of_first_order_differs_as_it_should(
    updates: int,
) -> None:
    # b' = c + (1 − α)^k (b − c); L = ½ (b' − d)²: dL/db = (1 − α)^k (b' − d), of first order b' − d; mean over tasks.
    policy, b = actor(1, 1, []), 0.4
    with torch.no_grad():
        policy.body.biases[0].fill_(b)
    c, d, shrunk = np.array([1.0, -2.0]), np.array([0.5, 3.0]), (1 - RATE) ** updates
    adapted = c + shrunk * (b - c)
    before, after = bias_rows(c.tolist()), bias_rows(d.tolist())
    batch = meta_batch([*[before] * updates, after])
    for order, factor in ((2, shrunk), (1, 1.0)):
        loss = loss_of(policy, Quadratic(), Quadratic(), updates=updates, order=order)
        slope = gradient(loss, batch)["actor.body.bias0"]
        assert slope.item() == pytest.approx((factor * (adapted - d)).mean(), rel=1e-12)


def test_an_update_along_the_score_has_a_closed_form() -> None:
    # −A log N(u; b, σ): slope −A (u − b)/σ², curvature A/σ². ρ = 1 after it: dL/db = −A' (u' − b')/σ² (1 − α A/σ²).
    policy, b, a, u, a2, u2 = actor(1, 1, []), 0.4, 1.5, 0.9, -0.7, 0.2
    with torch.no_grad():
        policy.body.biases[0].fill_(b)
    variance = np.exp(-0.6)
    adapted = b + RATE * a * (u - b) / variance
    log_std = -0.3 + RATE * a * ((u - b) ** 2 / variance - 1.0)
    before, after = bias_rows([u], a), bias_rows([u2], a2)
    acted = Gaussian(torch.full_like(after.mean, adapted), torch.full_like(after.mean, log_std))
    after = after._replace(mean=acted.mean, log_std=acted.log_std)
    loss = loss_of(policy, ScoreLoss())
    batch = meta_batch([before, after])
    assert loss.policy(loss.functional_parameters(), batch).mean.item() == pytest.approx(adapted)
    assert loss.policy(loss.functional_parameters(), batch).log_std.item() == pytest.approx(log_std)
    later = np.exp(-2 * log_std)
    by_mean, by_log_std = -a2 * (u2 - adapted) * later, -a2 * ((u2 - adapted) ** 2 * later - 1.0)
    across = -2.0 * RATE * a * (u - b) / variance  # d log σ'/db = d b'/d log σ
    wanted = by_mean * (1.0 - RATE * a / variance) + by_log_std * across
    assert gradient(loss, batch)["actor.body.bias0"].item() == pytest.approx(wanted)


def test_many_tasks_are_the_mean_of_each_alone() -> None:
    policy = actor()
    loss = loss_of(policy, ScoreLoss(), updates=2)
    every = phases(policy, loss.adaptation, tasks=4)
    together = gradient(loss, meta_batch(every))
    separate = [[PolicyRows(*(field[k : k + 1] for field in rows)) for rows in every] for k in range(4)]
    alone = [gradient(loss, meta_batch(one)) for one in separate]
    for name, slope in together.items():
        torch.testing.assert_close(slope, torch.stack([each[name] for each in alone]).mean(0))
    adapted = loss.adaptation.adapted(*loss.split(loss.functional_parameters()), every[:-1])
    for k, one in enumerate(separate):
        for name, value in loss.adaptation.adapted(*loss.split(loss.functional_parameters()), one[:-1]).items():
            torch.testing.assert_close(value[0], adapted[name][k])


def test_what_acted_diverges_from_itself_by_nothing_and_the_loss_is_a_torchrl_module() -> None:
    policy = actor()
    loss = loss_of(policy, ScoreLoss(), rate=partial(LearnedRate, rate=RATE)).double()
    batch = meta_batch(phases(policy, loss.adaptation, tasks=3))
    out = loss(batch)
    assert out["kl"].item() == pytest.approx(0.0, abs=1e-14)
    after = loss.rows_after(batch)
    assert out["loss_objective"].item() == pytest.approx(-mean(after.advantage, after).item())
    out["loss_objective"].backward()
    wanted = gradient(loss, batch)
    found = {f"actor.{name}": value.grad for name, value in policy.named_parameters()}
    found |= {f"rate.{name}": value.grad for name, value in loss.adaptation.rate.named_parameters()}
    assert set(found) == set(wanted)
    for name, slope in found.items():
        torch.testing.assert_close(slope, wanted[name])
    assert set(map(id, loss.parameters())) == {
        *map(id, policy.parameters()),
        *map(id, loss.adaptation.rate.parameters()),
    }


def test_learned_rates_have_the_gradient_of_the_update_that_they_scale() -> None:
    # θ' = θ − α ∘ g: dL/dα = −g ∘ dL/dθ'.
    policy = actor(1, 1, [])
    with torch.no_grad():
        policy.body.biases[0].fill_(0.4)
    loss = loss_of(policy, Quadratic(), Quadratic(), rate=partial(LearnedRate, rate=RATE)).double()
    batch = meta_batch([bias_rows([1.0]), bias_rows([0.5])])
    slope = gradient(loss, batch)["rate.rates"]
    names = [name for name, _ in policy.named_parameters()]
    inner, adapted = 0.4 - 1.0, 0.4 - RATE * (0.4 - 1.0)
    assert slope.tolist() == pytest.approx([-inner * (adapted - 0.5) if n == "body.bias0" else 0.0 for n in names])


@pytest.mark.parametrize("inner", [ScoreLoss(), ClippedLoss(0.3), Quadratic()])
@pytest.mark.parametrize("updates", [1, 2])
@pytest.mark.parametrize(
    ("activation", "rate", "order"), [("tanh", FixedRate, 2), ("relu", LearnedRate, 2), ("tanh", LearnedRate, 1)]
)
def test_the_derivatives_that_are_written_out_are_those_of_autograd(
    inner: InnerLoss, updates: int, activation: Activation, rate: type[FixedRate] | type[LearnedRate], order: int
) -> None:
    policy = actor(activation=activation)
    loss = loss_of(policy, inner, updates=updates, rate=partial(rate, rate=RATE), order=order).double()
    batch = meta_batch(phases(policy, loss.adaptation, tasks=3))
    like = {name: value.detach() for name, value in loss.functional_parameters().items()}
    vector = torch.cat([value.flatten() for value in like.values()])
    vector = vector + 1e-3 * draw(len(vector), seed=5)
    policy_at = AdaptedPolicy(loss, like, batch)
    near = policy_at.linearised(vector)
    at = vector.clone().requires_grad_()
    wanted = AutogradLinearised(policy_at(at), at)
    for found, expected in zip(near.policy, wanted.policy, strict=True):
        torch.testing.assert_close(found, expected)
    direction = draw(len(vector), seed=6)
    for found, expected in zip(near.pushed(direction), wanted.pushed(direction), strict=True):
        torch.testing.assert_close(found, expected)
    slope = Gaussian(*(draw(*part.shape, seed=7 + k) for k, part in enumerate(near.policy)))
    torch.testing.assert_close(near.pulled(slope), wanted.pulled(slope))


def test_the_hessian_of_the_divergence_goes_through_the_adaptation() -> None:
    policy = actor(hidden=[3])
    loss = loss_of(policy, ScoreLoss(), updates=2, rate=partial(LearnedRate, rate=RATE)).double()
    batch = meta_batch(phases(policy, loss.adaptation, tasks=3))
    like = {name: value.detach() for name, value in loss.functional_parameters().items()}
    vector, rows = torch.cat([value.flatten() for value in like.values()]), loss.rows_after(batch)
    policy_at = AdaptedPolicy(loss, like, batch)
    dense = torch.autograd.functional.hessian(lambda at: mean_divergence(policy_at(at), rows), vector)
    product = divergence_product(policy_at.linearised(vector), rows)
    found = torch.stack([product(unit) for unit in torch.eye(len(vector), dtype=torch.float64)])
    torch.testing.assert_close(found, cast(Tensor, dense), rtol=1e-7, atol=1e-9)


def test_a_number_out_of_its_range_is_told() -> None:
    with pytest.raises(ConfigError, match=r"algorithm\.adaptation\.order is 3; expected at most 2\."):
        loss_of(actor(), ScoreLoss(), order=3)
    with pytest.raises(ConfigError, match=r"algorithm\.adaptation\.rate\.rate is 0; expected a number above 0\."):
        loss_of(actor(), ScoreLoss(), rate=partial(FixedRate, rate=0.0))
    with pytest.raises(ConfigError, match=r"algorithm\.adaptation\.loss\.clip is 0; expected a number above 0\."):
        ClippedLoss(0.0)
