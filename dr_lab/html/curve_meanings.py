"""What the figures of training mean, for the captions of their plots; figures that are missing here have none."""

from collections.abc import Mapping

MEANINGS: Mapping[str, str] = {
    "episode_return": "Mean undiscounted return of the feasible episodes that ended, with exploration.",
    "episode_length": "Mean number of control steps of these episodes.",
    "infeasible_episodes": "Episodes that an infeasible context ended.",
    "objective": "The surrogate of the return that the update raises, a mean over its minibatches.",
    "critic_loss": "Loss of the critic, a mean over its minibatches.",
    "kl": "Divergence between the policy that acted and the updated one, nat.",
    "clipped": "Share of the actions whose probability ratio was clipped.",
    "std": "Standard deviation of the exploration, a mean over the actions.",
    "explained": "Share of the variance of the returns that the critic or the baseline explains.",
    "learning_rate": "Of the policy's optimiser.",
    "q": "Mean value that the critic gives to what the policy does.",
    "context_return": "Mean return of the feasible episodes that the distribution learner played.",
    "infeasible": "Share of the distribution learner's episodes that were infeasible.",
    "entropy": "Of the distribution of contexts, nat.",
    "discrepancy": "Between target and model, in contexts of the distribution, before an iteration.",
    "discrepancy_of_mean": "Between target and model, in the mean context, after an iteration.",
}
