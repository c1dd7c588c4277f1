"""What a training run came to, for a person."""

from dr_lab.reports.page import Page, Section
from dr_lab.reports.quantity import counted, number, percent, uncertain
from dr_lab.reports.tables import table
from dr_lab.reports.train import TrainReport

_NO_EPISODE = "No episode ended, so that no return is known; dr-lab evaluate plays whole ones."

_WHOLE = 9.95  # s, from which on 10 is said


def train_page(report: TrainReport) -> Page:
    """How long was trained, what the policy returns, which one is deployed, and what it was trained on."""
    lines = [_deployed(report), _trained(report)]
    if report.rollout_frames:
        lines.append(f"Further episodes were played to learn from: {report.rollout_frames} control steps.")
    if report.infeasible_episodes:
        ended = report.ended_episodes
        of_all = "" if ended is None else f" of {ended} ({percent(report.infeasible_episodes / ended)})"
        told = f"Episodes in infeasible contexts, which no mean return counts: {report.infeasible_episodes}"
        lines.append(f"{told}{of_all}.")
    rows = [[name, number(p.mean), number(p.std, 3), p.unit] for name, p in report.context.items()]
    context = Section("context", "Contexts", table(["parameter", "mean", "std", "unit"], rows))
    told = "\n\n".join(line for line in lines if line)
    return Page(f"{report.algorithm} on {report.env}", told, [context, *_ladder(report)])


def _trained(report: TrainReport) -> str:
    taken = (
        f"Trained for {report.frames} control steps in {_seconds(report)} s, {counted(report.iterations, 'iteration')}."
    )
    if report.adapted_returns:
        first, *others = map(number, report.adapted_returns)
        after = ", ".join(f"{value} after {counted(k, 'update')}" for k, value in enumerate(others, start=1))
        return f"Mean return in the last tasks: {first} before an update, {after}. {taken}"
    value = report.final_return
    if value is None:
        return f"{_NO_EPISODE if report.deployed_return is None else ''} {taken}".strip()
    ended = "the episodes" if report.final_episodes is None else counted(report.final_episodes, "episode")
    return (
        f"{taken} While it trained, {ended} that ended last returned {number(value)} on average, with exploration; "
        "episodes that outlast the run are not among them."
    )


def _seconds(report: TrainReport) -> str:
    """How long it took: whole seconds from ten on, else tenths."""
    return f"{report.seconds:.{1 if report.seconds < _WHOLE else 0}f}"


def _ladder(report: TrainReport) -> list[Section]:
    """Every iteration of a learner that compares the model with a target; none of others."""
    if not report.ladder:
        return []
    names = list(report.ladder[0].context)
    rows = [
        [
            str(rung.iteration),
            *map(number, (rung.discrepancy, rung.discrepancy_of_mean, rung.divergence)),
            *(uncertain(rung.context[name].mean, rung.context[name].std, rung.context[name].unit) for name in names),
        ]
        for rung in report.ladder
    ]
    played = sum(rung.target_steps for rung in report.ladder)
    told = (
        f"Model and target, of which {played} control steps were seen: the discrepancy before an iteration (mean of "
        "the contexts drawn) and after it (at the mean), and the largest KL(new‖old) of its updates in nat."
    )
    rungs = told + "\n\n" + table(["iteration", "before", "after", "KL", *names], rows)
    return [Section("ladder", "Target and model", rungs)]


def _deployed(report: TrainReport) -> str:
    choice = report.choice
    if choice is None:
        return ""
    kept = len(choice.snapshots)
    best = f", the best of the {kept} that were kept" if kept > 1 else ""
    which = "by which it was chosen" if kept > 1 else "that were played with it"
    played = f"The episodes {which}, {choice.choice_frames} control steps in all"
    if report.deployed_return is None:
        told = f"The deployed policy is that of control step {choice.chosen}{best}."
        return f"{told} {played}, are no part of the training. dr-lab evaluate plays others."
    lucky = f", and make the best of {kept} seem somewhat better than it is" if kept > 1 else ""
    return (
        f"The deployed policy returns {number(report.deployed_return)} on average, without exploration. It is that of "
        f"control step {choice.chosen}{best}. {played}, are no part of the training{lucky}. dr-lab evaluate plays "
        "others."
    )
