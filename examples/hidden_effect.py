# %% [markdown]
# # A hidden effect
#
# A simulated pendulum hides an effect that its model lacks. We record its logs, look at what the model gets wrong, let
# the catalogue be ranked, and then compare the answer with the truth, which lies beside the logs.

# %%
from pathlib import Path

from dr_lab import Comparison, record

# %% [markdown]
# ## Logs of a machine with a secret
#
# `record` plays an independent simulator: SciPy on the equations of motion, encoders with steps, clocks with offset and
# jitter. Masses and dampings differ from the model's, too. `plant/hidden` says what is hidden;
# `dr-lab record --help` lists what else could be.

# %%
logs = record("plant=pendulum", "plant/hidden=pendulum/coulomb_friction", "seed=4", "output=logs")

# %% [markdown]
# ## What the model gets wrong
#
# The remaining arguments of `load` are overrides, as they are typed behind `dr-lab compare`.

# %%
comparison = Comparison.load("pendulum", "pendulum", f"measurements.logs=[{', '.join(map(str, logs))}]")
before = comparison.compare()
for place in before.failing.where:
    print(f"{place.signal} where {place.region}: {place.share or 0.0:.0%} of the error")

# %% [markdown]
# ## Which effect is missing
#
# `diagnose` puts every effect at every site, fits the promising ones, and scores them on logs that were not fitted.

# %%
report = comparison.diagnose()
print(report.verdict, "·", report.judged.reason)
for entry in report.judged.ranking[:5]:
    print(entry.label, entry.status, entry.held_out_chi2)  # χ² only of those that were fitted to all windows

# %% [markdown]
# ## The truth

# %%
print(Path("logs/truth.yaml").read_text(encoding="utf-8"))
