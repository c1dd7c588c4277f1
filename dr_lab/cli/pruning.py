"""The pruner of a study, in the process where a trial runs."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from hydra.conf import HydraConf
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.sweeps.progress import told_to


def watched(hydra: HydraConf, number: int) -> AbstractContextManager[None]:
    """While a job runs, let the study's pruner see its figures; nothing where the sweep has no pruner.

    Args:
        hydra: Hydra's node.
        number: of the job, which is its trial's.
    """
    if OmegaConf.select(hydra.sweeper, "pruner") is None:
        return nullcontext()
    from dr_lab.sweeps.study import Pruning  # noqa: PLC0415  Optuna takes a second to import

    pruner = instantiate(hydra.sweeper.pruner)
    return told_to(Pruning(Path(hydra.sweep.dir), number, pruner, hydra.sweeper.prune_on))
