"""What the figures of training mean, for the captions of their plots; figures that are missing here have none."""

import re
from collections.abc import Mapping

_MEANINGS: Mapping[str, str] = {
    "episode_return": "Mean undiscounted return of the feasible episodes that ended, with exploration.",
    "episode_length": "Mean number of control steps of the episodes that ended.",
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
    "divergence": "KL of the distribution, nat: from the prior (lsdr), or the largest of an update (simopt).",
    "temperature": "Of the weights by which the last update counts contexts.",
    "target_steps": "Control steps of the target's episodes.",
    "proposals_infeasible": "Share of the particles' proposals that were infeasible.",
    "discriminator_accuracy": "Share that the discriminator tells right, of both sides alike; ½ is chance.",
    "discriminator_loss": "Loss of the discriminator.",
    "proposal_reward": "Mean reward of the particles' proposals.",
    "particle_spread": "Mean distance between the particles' parameters.",
    "particle_loss": "Loss of the particles' critics.",
    "tasks_learnt": "Tasks of the batch whose episodes were feasible.",
    "return_after_k": "Mean return over the tasks after so many updates, with exploration.",
    "episodes_learnt": "Feasible episodes of the batch.",
    "gain": "Mean return after the last update less that before the first.",
    "negative_adaptation": "Share of the tasks in which the updates lowered the return.",
    "gradient": "Length of the gradient that the step starts from.",
    "improvement": "By which the step raised the surrogate of the return.",
    "trials": "Lengths of the step that were tried.",
    "distillation": "Divergence of student and teachers before it learns from a batch, nat.",
    "distillation_after": "The same after it has learned from it.",
    "worst_teacher": "Mean return of the teacher that does worst in its domain.",
    "return_while_training_on": "Interquartile mean over the contexts.",
    "infeasible_share_while_training_on": "Share of the contexts without a return.",
}


def meaning(name: str) -> str:
    """A sentence on a figure, whose name may end in a number; empty where there is none."""
    return _MEANINGS.get(re.sub(r"_\d+$", "_k", name.replace(" ", "_")), "")
