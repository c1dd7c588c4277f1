"""Supervised learning of a policy from what others would do."""

from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor

from dr_lab.bounds import Count, NotNegative, Positive, require_bounds
from dr_lab.networks.adam import Adam
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian, divergence
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.seeding import derived_seed


class Distillation:
    """Moves a student θ by L = E[KL(π_teacher ‖ π_θ)], the mean over states, each with a teacher of its own.

    Between Gaussians the divergence is known in closed form, and with it the gradient:
    ∂KL/∂μ = (μ − μ_teacher)/σ², ∂KL/∂log σ = 1 − (σ_teacher² + (μ − μ_teacher)²)/σ².

    Source: Brosseit et al. 2021, algorithm 1, lines 7 to 9, whose sum over teachers is this mean times their number.
    The released code weighs by the density of the student's own actions instead, which is another divergence.

    Args:
        student: π_θ.
        seed: of the order of states.
        epochs: passes over the states of a batch.
        minibatch: states in a step.
        rate: learning rate.
        adam_epsilon: ε of Adam.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        student: GaussianActor,
        seed: int,
        epochs: Count,
        minibatch: Count,
        rate: Positive,
        adam_epsilon: NotNegative,
    ) -> None:
        self.epochs, self.minibatch, self.rate, self.adam_epsilon = epochs, minibatch, rate, adam_epsilon
        require_bounds(self, "algorithm.distillation", Distillation)
        self._student = student
        self._parameters = FlatParameters([student.log_std, *student.body.parameters()])
        self._gradients = self._parameters.gradients_of(student.body)
        self._adam = Adam(self._parameters, adam_epsilon)
        self._generator = torch.Generator().manual_seed(derived_seed(seed, "distillation"))

    @torch.no_grad()
    def learn(self, observation: Tensor, teacher: Gaussian) -> dict[str, float]:
        """Learn from one batch; the normaliser is renewed first.

        Args:
            observation: of b states, shape (b, o), as they are.
            teacher: what the teacher of each state would do, over actions scaled to ±1, shape (b, nu) each.

        Returns:
            Mean divergence before and after, in nats, and the student's mean σ.
        """
        self._student.normaliser.update(observation)
        rows = self._student.normaliser(observation)
        before = self._divergence(rows, teacher)
        for _ in range(self.epochs):
            order = torch.randperm(len(rows), generator=self._generator).to(rows.device)
            for part in order.split(self.minibatch):
                self._step(rows[part], Gaussian(teacher.mean[part], teacher.log_std[part]))
        std = self._student.log_std.exp().mean().item()
        return {"distillation": before, "distillation_after": self._divergence(rows, teacher), "std": std}

    def explore_anew(self, seed: int) -> None:
        """Take the states of every pass in another order.

        Args:
            seed: of the order.
        """
        self._generator.manual_seed(derived_seed(seed, "explore_anew", "distillation"))

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs, the student apart."""
        return {"adam": self._adam.state_dict(), "generator": self._generator.get_state()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._adam.load_state_dict(state["adam"])
        self._generator.set_state(state["generator"])

    def _step(self, rows: Tensor, teacher: Gaussian) -> None:
        layers, log_std = self._student.body.layers(rows), self._student.log_std
        apart, precision = layers[-1] - teacher.mean, (-2.0 * log_std).exp()
        self._student.body.backward(layers, apart * precision / len(rows), *self._gradients)
        spread = (2.0 * teacher.log_std).exp() + apart.square()
        self._parameters.gradient_of(log_std).copy_((1.0 - spread * precision).mean(0))
        self._adam.step(self.rate)

    def _divergence(self, rows: Tensor, teacher: Gaussian) -> float:
        return divergence(teacher, Gaussian(self._student.body(rows), self._student.log_std)).mean().item()
