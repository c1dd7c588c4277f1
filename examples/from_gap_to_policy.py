# %% [markdown]
# # From a gap to a policy
#
# The driver of a Furuta pendulum is 40 ms late, and the model knows nothing of it. A policy that balances the model
# falls on the machine. We find the delay in logs, train on the corrected model with the uncertainty that the fit left,
# and play the policy on the machine.

# %%
from dr_lab import Comparison, evaluate, record, train

# %% [markdown]
# ## Logs, and what they say

# %%
logs = record("experiment=late_furuta", "output=late")
closed = Comparison.load("furuta", "furuta", f"measurements.logs=[{', '.join(map(str, logs))}]").close()
print(closed.verdict, closed.ladder[-1].effects)

# %% [markdown]
# ## A policy for that machine
#
# `experiment=sim2real_furuta` takes the run's model with its effects, and draws its parameters from their covariance.
# `experiment=sim2real_furuta_uncorrected` would train on the model as documented, to compare.

# %%
trained = train("experiment=sim2real_furuta", f"run={closed.run}")
print(f"return in the model: {trained.final_return:.1f}")

# %% [markdown]
# ## On the machine
#
# `real_vs_sim` plays the policy on the machine, and from the same starts in the model.

# %%
played = evaluate("experiment=sim2real_furuta_real", f"run={trained.run}")
for name, value in played.figures.items():
    print(f"{name}: {value:.4g}")
