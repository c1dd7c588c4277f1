"""Verb `export`: a trained policy for the robot."""

import json
from pathlib import Path

import numpy as np
import torch
from rich.console import Console

from dr_lab.bounds import Natural
from dr_lab.deployment.described import course_csv, described, told
from dr_lab.deployment.onnx_file import Bounded, OnnxSettings, difference, onnx_of
from dr_lab.evaluators.trained_run import Compose, TrainedRun, subject_of
from dr_lab.files import write_bytes, write_text
from dr_lab.reports.json_file import write_json
from dr_lab.reports.plain import to_plain
from dr_lab.reports.policy import PolicyReport
from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.training.episodes import play_episodes


def export(trained: TrainedRun, onnx: OnnxSettings, seed: Natural, compose: Compose, run_dir: Path) -> PolicyReport:
    """Write the policy that a training run left as a file that any control loop can run.

    Files: ``policy.onnx`` (observation in, action out, cut off at its bounds), ``policy.json`` (schema dr_lab/policy/1:
    what each input and output is; ``policy.onnx`` keeps it, too), ``episode.csv`` (one episode in the model at its
    nominal context, to check one's own code with). Nothing is written where the file does not act as the policy does.

    Args:
        trained: the training run.
        onnx: how the file is written and checked.
        seed: of the episodes' starts.
        compose: gives the arguments of a verb, built from its name, overrides and the folder that records them.
        run_dir: the run folder.

    Raises:
        DataError: there is no such run, or it has no readable checkpoint.
        DrLabError: the file does not act as the policy does.
    """
    torch.set_num_threads(1)  # small networks gain nothing from a second thread
    folder = trained.folder()
    subject = subject_of(folder, compose, trained.threads)
    slots = subject.slots(1, seed)
    played = play_episodes(subject.setting, subject.policy, None, onnx.episodes, seed, subject.threads)
    report = described(subject, folder, (slots.low, slots.high), played, run_dir)
    policy = Bounded(subject.policy, slots.low, slots.high)
    seen = np.concatenate([episode.observation for episode in played])
    file = onnx_of(policy, seen.shape[1], json.dumps(to_plain(report), ensure_ascii=False), onnx)
    apart = difference(file, policy, seen, onnx)
    write_bytes(run_dir / "policy.onnx", file)
    write_json(run_dir / "policy.json", report)
    write_text(run_dir / "episode.csv", course_csv(played[0]))
    Console().print(ScreenMarkdown(told(report)))
    print(f"\npolicy.onnx acts as the policy, to {apart:.1g} of a command's range, in {len(seen)} observations.")
    return report
