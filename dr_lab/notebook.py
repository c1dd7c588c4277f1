"""The verbs in a notebook: a comparison whose verbs are methods, and functions that make logs, train and evaluate."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.arguments import arguments_of
from dr_lab.cli.compose import compose_from, require_one_run
from dr_lab.cli.explain import raised_plainly
from dr_lab.cli.folders import shipped, split_config_dir
from dr_lab.cli.groups import defaults_of
from dr_lab.cli.job import Job, build, claim, numbered
from dr_lab.cli.provenance import write_config
from dr_lab.cli.threads import algebra_on_one_thread
from dr_lab.comparison.comparison import Comparison
from dr_lab.errors import ConfigError
from dr_lab.recorders.look import Look
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.gap import GapReport
from dr_lab.reports.train import TrainReport

_OWN = ("comparison", "recorder")  # arguments of the verbs that do not come from their configuration


@dataclass(frozen=True)
class NotebookComparison(Comparison):
    """A comparison whose verbs are methods; ``from dr_lab import Comparison`` gives this class.

    Each verb does what `dr-lab` does on the command line: it writes a run folder, prints what it finds and returns the
    report. `dataclasses.replace` puts another model, other logs or other settings in place of those that were loaded.

    Example:
        >>> comparison = Comparison.load("furuta", "furuta", "windows.length=0.5")
        >>> report = comparison.close()
        >>> report.verdict, report.ladder[-1].effects
        ('named', ('coulomb_friction@arm',))

    Attributes:
        recorder: how recordings look.
        config_folders: where configuration files are found, first searched first.
        overrides: with which it was loaded.
        loaded: what these gave; while nothing is replaced, run folders have the ``config.yaml`` that `from_run` reads.
    """

    recorder: Look
    config_folders: tuple[Path, ...]
    overrides: tuple[str, ...]
    loaded: Comparison

    @classmethod
    def load(
        cls, model: str, measurements: str, *overrides: str, config_dir: Path | str | None = None
    ) -> "NotebookComparison":
        """Load model and logs by name, with the default settings.

        Args:
            model: option of the group ``model``, e.g. ``"furuta"``.
            measurements: option of the group ``measurements``.
            overrides: as on the command line of ``dr-lab compare``, e.g. ``"windows.length=0.5"``.
            config_dir: folder with the user's own groups, searched first.

        Raises:
            ConfigError: the configuration does not fit, or an override names nothing.
            DataError: the logs cannot be read.
        """
        folders = _folders(config_dir)
        typed = _texts((f"model={model}", f"measurements={measurements}", *overrides))
        with raised_plainly("compare", folders):
            built = arguments_of("compare", compose_from(folders, "compare", typed), folders)[1]
        loaded: Comparison = built["comparison"]
        return cls(loaded.model, loaded.measurements, loaded.settings, built["recorder"], folders, typed, loaded)

    def compare(self, run_dir: Path | str | None = None) -> GapReport:
        """Measured beside simulated, and where the model fails: `dr_lab.workflows.compare.compare`.

        Args:
            run_dir: the run folder, or ``<name>_2`` and so on where another run has it; None for
                ``outputs/compare/<model>/<time>/``.
        """
        return self._run("compare", run_dir)

    def fit(self, run_dir: Path | str | None = None) -> GapReport:
        """Calibrate the plain model: `dr_lab.workflows.fit.fit`.

        Args:
            run_dir: as in `compare`.
        """
        return self._run("fit", run_dir)

    def diagnose(self, effects: str | Sequence[str] = ("all",), run_dir: Path | str | None = None) -> GapReport:
        """Rank effects on held-out logs and say which one is missing: `dr_lab.workflows.diagnose.diagnose`.

        Args:
            effects: names of those that are tried; ``"all"`` for the catalogue.
            run_dir: as in `compare`.
        """
        return self._run("diagnose", run_dir, _chosen(effects))

    def add(self, effect: str, run_dir: Path | str | None = None, **site: str) -> GapReport:
        """Add one effect and refit, e.g. ``add("coulomb_friction", joint="arm")``: `dr_lab.workflows.add.add`.

        Args:
            effect: its name.
            run_dir: as in `compare`.
            site: one of ``joint``, ``actuator``, ``body``, ``sensor``, or none where the effect has a single site.
        """
        return self._run("add", run_dir, f"effect={effect}", *(f"effect.{kind}={name}" for kind, name in site.items()))

    def close(
        self, effects: str | Sequence[str] = ("all",), most: int | None = None, run_dir: Path | str | None = None
    ) -> GapReport:
        """Diagnose and add until nothing more is supported: `dr_lab.workflows.close.close`.

        Args:
            effects: names of those that are tried; ``"all"`` for the catalogue.
            most: effects added at most; None for as many as the command's default.
            run_dir: as in `compare`.
        """
        return self._run("close", run_dir, _chosen(effects), *([] if most is None else [f"most={most}"]))

    def _run(self, verb: str, run_dir: Path | str | None, *overrides: str) -> GapReport:
        typed = (*self.overrides, *overrides)
        with raised_plainly(verb, self.config_folders):
            cfg = compose_from(self.config_folders, verb, typed)
            workflow, arguments = arguments_of(verb, cfg, self.config_folders, given=_OWN)
        wanted = _folder(run_dir, cfg, verb, self.model.name)
        if all(getattr(self, part) is getattr(self.loaded, part) for part in ("model", "measurements", "settings")):
            folder = claim(wanted)
            write_config(folder, verb, typed, "run", cfg, self.config_folders[:-1])
        else:
            folder = next(each for each in numbered(wanted) if not (each.is_dir() and any(each.iterdir())))
            folder.mkdir(parents=True, exist_ok=True)
        with algebra_on_one_thread():
            return workflow(comparison=self, recorder=self.recorder, run_dir=folder, **arguments)


def record(
    *overrides: str, config_dir: Path | str | None = None, run_dir: Path | str | None = None
) -> tuple[Path, ...]:
    """Write logs, as `dr-lab record` does: `dr_lab.workflows.record.record`.

    Example:
        >>> record("source=plant", "plant=pendulum", "plant/hidden=pendulum/coulomb_friction", "output=logs")

    Args:
        overrides: as on the command line.
        config_dir: folder with the user's own groups, searched first.
        run_dir: where they go without ``output=``; None for ``outputs/record/<time>/``.

    Raises:
        DrLabError: whatever the command would say.

    Returns:
        The MCAP files.
    """
    return _job("record", "model.name", overrides, config_dir, run_dir)()


def train(*overrides: str, config_dir: Path | str | None = None, run_dir: Path | str | None = None) -> TrainReport:
    """Train a policy, as `dr-lab train` does: `dr_lab.workflows.train.train`.

    Example:
        >>> report = train("env=furuta_balance", "frames=20000")
        >>> report.deployed_return, report.run

    Args:
        overrides: as on the command line; ``resume=FOLDER`` goes on with an interrupted run.
        config_dir: folder with the user's own groups, searched first.
        run_dir: the run folder; None for ``outputs/train/<environment>/<time>/``.

    Raises:
        DrLabError: whatever the command would say.
    """
    return _job("train", "env.name", overrides, config_dir, run_dir)()


def evaluate(
    *overrides: str, config_dir: Path | str | None = None, run_dir: Path | str | None = None
) -> EvaluateReport:
    """Evaluate a trained policy, as `dr-lab evaluate` does: `dr_lab.workflows.evaluate.evaluate`.

    Example:
        >>> report = evaluate(f"run={trained.run}", "evaluator=grid")
        >>> report.figures

    Args:
        overrides: as on the command line; ``run=FOLDER`` is the training run, by default the newest.
        config_dir: folder with the user's own groups, searched first.
        run_dir: the run folder; None for ``outputs/evaluate/<time>/``.

    Raises:
        DrLabError: whatever the command would say.
    """
    return _job("evaluate", "evaluator.name", overrides, config_dir, run_dir)()


def _job(
    verb: str, place: str, overrides: Sequence[str], config_dir: Path | str | None, run_dir: Path | str | None
) -> Callable[[], Any]:
    """A verb's function with the arguments that a command line gives; `place` is the key that a run's path names."""
    folders, typed = _folders(config_dir), _texts(overrides)
    entries = defaults_of(shipped() / f"{verb}.yaml")
    (base,) = (str(entry["base"]) for entry in entries if isinstance(entry, dict) and "base" in entry)
    with raised_plainly(verb, folders):
        require_one_run(folders, verb, typed)
        cfg = compose_from(folders, verb, typed)
        folder = _folder(run_dir, cfg, verb, str(OmegaConf.select(cfg, place) or ""))
        workflow, arguments = build(Job(verb, typed, base, folder, folders), cfg)

    def run() -> Any:  # noqa: ANN401  each verb returns its own
        with algebra_on_one_thread():
            return workflow(**arguments)

    return run


def _folders(config_dir: Path | str | None) -> tuple[Path, ...]:
    return split_config_dir([] if config_dir is None else ["--config-dir", str(config_dir)])[0]


def _folder(run_dir: Path | str | None, cfg: DictConfig, verb: str, subject: str) -> Path:
    """The wanted run folder."""
    own = Path(cfg.outputs) / verb / subject / time.strftime("%Y-%m-%d_%H-%M-%S")
    return (own if run_dir is None else Path(run_dir)).expanduser()


def _texts(overrides: Sequence[object]) -> tuple[str, ...]:
    """Overrides, of which each must be a text of its own."""
    for override in overrides:
        if not isinstance(override, str):
            raise ConfigError(
                f"{override!r} is no override; expected texts, one for each key: 'seed=1', 'threads=2', …"
            )
    return tuple(map(str, overrides))


def _chosen(effects: str | Sequence[str]) -> str:
    names = (effects,) if isinstance(effects, str) else effects
    return f"effect={names[0]}" if len(names) == 1 else f"effect=[{','.join(names)}]"
