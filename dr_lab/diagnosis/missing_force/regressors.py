"""The regressors of missing forces; a module of its own, because scikit-learn takes long to import."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.linear_model import OrthogonalMatchingPursuit
from sklearn.model_selection import GroupKFold, cross_val_predict

from dr_lab.trajectory import Array

Groups = NDArray[np.intp]


class Pursuit(RegressorMixin, BaseEstimator):
    """Orthogonal matching pursuit that compares columns scaled to one size.

    Args:
        terms: number of columns that get a coefficient.
    """

    def __init__(self, terms: int) -> None:
        self.terms = terms

    def fit(self, columns: Array, force: Array) -> Self:
        """Find coefficients ``coef_`` of columns (n, c) whose sum is the force (n,)."""
        sizes = np.sqrt((columns**2).mean(0))
        sizes = np.where(sizes > 0, sizes, 1.0)
        pursuit = OrthogonalMatchingPursuit(n_nonzero_coefs=self.terms, fit_intercept=False)
        self.coef_ = pursuit.fit(columns / sizes, force).coef_ / sizes
        return self

    def predict(self, columns: Array) -> Array:
        """The force of columns (n, c), shape (n,)."""
        return columns @ self.coef_


def forest(trees: int) -> ExtraTreesRegressor:
    """A regression that follows any bounded function of few variables: the mean of so many trees."""
    return ExtraTreesRegressor(trees, min_samples_leaf=3, random_state=0)


def left_out(regressor: Any, columns: Array, force: Array, groups: Groups, folds: int) -> Array:  # noqa: ANN401 (sklearn)
    """Prediction of each row from the folds that it is not in, shape (n,)."""
    return np.asarray(cross_val_predict(regressor, columns, force, groups=groups, cv=GroupKFold(folds)))
