# %% [markdown]
# # An own robot
#
# A two-joint arm as it was drawn, and five logs of it as CSV. What does the drawing lack? The files are those of
# `examples/own_robot`: put your own in their place.

# %%
import shutil
from pathlib import Path

from dr_lab import Comparison

# %% [markdown]
# ## What you need
#
# `mine/model/rig.xml` is the MJCF. `mine/model/rig.yaml` says which of its numbers may be wrong, with bounds.
# `mine/measurements/rig.yaml` says which column is which joint or actuator, and which logs are held out.

# %%
# Where the examples are: beside this file, or below the folder in which a notebook was opened.
examples = Path(globals().get("__file__", "examples/own_robot.py")).resolve().parent
shutil.copytree(examples / "own_robot", ".", dirs_exist_ok=True)
print(Path("mine/measurements/rig.yaml").read_text(encoding="utf-8"))

# %% [markdown]
# ## Close the gap
#
# `close` calibrates the model, names what is missing, adds it and goes on, until the error is at the noise floor or
# nothing more is supported.

# %%
comparison = Comparison.load("rig", "rig", config_dir=Path("mine"))
report = comparison.close()

# %% [markdown]
# ## The answer
#
# Each rung of the ladder is a model. χ² = 1 is the noise of the encoders.

# %%
for rung in report.ladder:
    print(f"{' + '.join(rung.effects) or 'plain model'}: χ² {rung.held_out.chi2:.4g}")
for name, value in report.ladder[-1].parameters.items():
    print(f"{name} = {value.value:.4g} ± {value.std:.2g} {value.unit}")

# %% [markdown]
# The run folder holds the improved model as plain MJCF, the covariance of its parameters and a recording for Rerun.

# %%
print(sorted(path.name for path in Path(report.run).iterdir()))
