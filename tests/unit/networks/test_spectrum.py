"""Ends of a spectrum: of a matrix whose spectrum is known, and of a network's loss against its dense Hessian."""

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.func import functional_call

from dr_lab.networks.critic import Critic
from dr_lab.networks.flat import parts_of
from dr_lab.networks.spectrum import curvatures, ends_of_spectrum, hessian_product

SIZE = 60


def quadratic() -> tuple[Tensor, np.ndarray, np.ndarray]:
    """½ θᵀ H θ with eigenvalues −3, −1, 0 … 0, 2, 5, 10."""
    values = np.zeros(SIZE)
    values[:2], values[-3:] = [-3.0, -1.0], [2.0, 5.0, 10.0]
    vectors = np.linalg.qr(np.random.default_rng(0).normal(size=(SIZE, SIZE)))[0]
    return torch.from_numpy(vectors * values @ vectors.T), values, vectors


def test_the_spectrum_of_a_quadratic_is_found_from_both_ends() -> None:
    matrix, values, vectors = quadratic()
    product = hessian_product(lambda at: 0.5 * at @ matrix @ at, torch.ones(SIZE, dtype=torch.float64))
    found, along = ends_of_spectrum(product, SIZE, 2, seed=0)
    np.testing.assert_allclose(found, [10.0, 5.0, -1.0, -3.0], atol=1e-9)
    np.testing.assert_allclose(np.abs((along @ vectors)[:, [-1, -2, 1, 0]]), np.eye(4), atol=1e-7)
    every, _ = ends_of_spectrum(product, SIZE, SIZE, seed=0)
    np.testing.assert_allclose(every, values[np.argsort(values)[::-1]], atol=1e-9)


def network() -> tuple[Critic, Tensor, Tensor]:
    draw = torch.Generator().manual_seed(0)
    observation, target = (torch.randn(20, width, generator=draw, dtype=torch.float64) for width in (3, 1))
    return Critic(3, 0, [5, 4], "tanh").double(), observation, target[:, 0]


def test_the_spectrum_of_a_networks_loss_is_that_of_its_dense_hessian() -> None:
    critic, observation, target = network()
    parameters = {name: value.detach() for name, value in critic.named_parameters()}
    at = torch.cat([value.flatten() for value in parameters.values()])

    def losses(vector: Tensor) -> Tensor:
        return (functional_call(critic, parts_of(vector, parameters), (observation,)) - target).square()

    dense = np.asarray(torch.autograd.functional.hessian(lambda vector: losses(vector).mean(), at))
    wanted, vectors = np.linalg.eigh(dense)
    found, along = ends_of_spectrum(hessian_product(lambda v: losses(v).mean(), at), len(at), 3, seed=0)
    np.testing.assert_allclose(found, [*wanted[:-4:-1], *wanted[2::-1]], atol=1e-9)
    np.testing.assert_allclose(np.abs(along[0] @ vectors[:, -1]), 1.0, atol=1e-7)
    each = curvatures(losses, at, along[0])
    assert each.shape == (20,)
    assert each.mean() == pytest.approx(found[0])
