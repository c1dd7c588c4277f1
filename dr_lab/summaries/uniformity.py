"""Whether contexts were drawn alike often in all bins, judged by counts of several runs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f

from dr_lab.reports.plain import Number
from dr_lab.trajectory import Array

LEAST = 5  # draws that a bin of a block is to be expected to hold (Cochran 1954)


@dataclass(frozen=True)
class Uniformity:
    """Pearson's test of counts against the uniform distribution, block by block, all blocks together.

    Attributes:
        blocks: that hold enough draws to be judged.
        chi2: Σ_b Σ_j (n_bj − N_b/B)²/(N_b/B) of the counts of all runs together.
        dof: its degrees of freedom, blocks · (B − 1).
        p: probability of a larger one, were all draws uniform and independent of one another.
        p_between: the same where draws of a run may depend on one another; None of one run.
    """

    blocks: int
    chi2: float
    dof: int
    p: float
    p_between: Number


def uniformity(counts: NDArray[np.integer]) -> Uniformity | None:
    """Judge the counts.

    Proposals of a walk lie near one another, which raises χ² without any preference. How much, the runs tell by how
    they differ: with H their χ² against the share that they have in common, H/dof_H estimates the design effect, and
    (χ²/dof)/(H/dof_H) has Fisher's distribution with (dof, dof_H) degrees of freedom about. So only what several runs
    prefer alike counts.

    Source: Rao, Scott 1981, "The analysis of categorical data from complex sample surveys", first-order correction,
    with runs for clusters.

    Args:
        counts: draws by run, block and bin, shape (r, k, b).

    Returns:
        None where no block holds enough draws.
    """
    together = counts.sum(axis=0)
    enough = together.sum(axis=1) >= LEAST * counts.shape[2]
    if not enough.any():
        return None
    judged = together[enough]
    expected = judged.sum(axis=1, keepdims=True) / judged.shape[1]
    value, dof = float((np.square(judged - expected) / expected).sum()), judged.shape[0] * (judged.shape[1] - 1)
    between, dof_between = _between(counts[:, enough])
    p_between = None
    if dof_between and between:
        p_between = float(f.sf((value / dof) / (between / dof_between), dof, dof_between))
    return Uniformity(len(judged), value, dof, float(chi2.sf(value, dof)), p_between)


def _between(counts: NDArray[np.integer]) -> tuple[float, int]:
    """χ² of runs against what they have in common, block by block, and its degrees of freedom."""
    value, dof = 0.0, 0
    for block in counts.swapaxes(0, 1):
        rows: Array = block[block.sum(axis=1) > 0][:, block.sum(axis=0) > 0].astype(float)
        expected = np.outer(rows.sum(axis=1), rows.sum(axis=0)) / rows.sum()
        value += float((np.square(rows - expected) / expected).sum())
        dof += (rows.shape[0] - 1) * (rows.shape[1] - 1)
    return value, dof
