"""What a benchmark found, for a person."""

from collections.abc import Sequence

from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.rates import parameter_errors
from dr_lab.benchmark.score import mark
from dr_lab.benchmark.scoring import Aliases
from dr_lab.reports.benchmark import BenchmarkReport, Rate
from dr_lab.reports.page import Page, Section
from dr_lab.reports.quantity import ABSENT, number, percent
from dr_lab.reports.tables import table

SAID = {
    "top_1": "effect and site right, one hidden effect",
    "top_3": "… among the first three",
    "identifiable": "… of those that the data can show",
    "both_found": "all found, several hidden effects",
    "doubles": "… two hidden effects",
    "false_alarm": "false alarms, nothing hidden",
    "wrong_with_confidence": "a wrong effect named, all cases",
    "outside_unexplained": "`unexplained`, effect outside of the catalogue",
    "abstained_equivalent": "`equivalent` answered, one hidden effect",
    "abstained_none": "`none` answered, one hidden effect",
    "abstained_unexplained": "`unexplained` answered, one hidden effect",
    "parameter_within_stated": "main parameter within two of its stated ±, right answers at the floor",
    "median_chi2": "median held-out χ²",
    "median_parameter_error": "median error of the main parameter",
    "median_cpu": "median CPU s a case",
    "mean_cpu": "mean CPU s a case",
    "median_wall": "median wall s a case",
}
_KINDS = {"none": "nothing hidden", "single": "one effect", "several": "several", "outside": "outside"}


def rates_page(report: BenchmarkReport) -> str:
    """The figures with their intervals and goals."""
    rows = []
    for name, said in SAID.items():
        goal = report.goals.get(name)
        told = ("", "") if goal is None else (goal.goal, {True: "met", False: "MISSED", None: "not judged"}[goal.met])
        rows.append([said, *_figure(report, name), *told])
    failed = [f"- failed: {name}: {message}" for name, message in report.failed.items()]
    rows = [row for row in rows if row[1] != ABSENT]
    return "\n".join([table(["figure", "value", "95 % interval", "cases", "goal", ""], rows), "", *failed])


def machines_page(report: BenchmarkReport) -> str:
    """The main figures of each machine."""
    names = ("top_1", "both_found", "false_alarm", "outside_unexplained")
    rows = [
        [
            machine,
            str(own.cases),
            *(_share(own.rates[name]) for name in names),
            number(own.medians["median_chi2"]),
            percent(own.medians["median_parameter_error"]),
            number(own.medians["mean_cpu"], 3),
        ]
        for machine, own in report.machines.items()
    ]
    header = ["one effect", "several", "false alarms", "outside", "median χ²", "parameter error", "CPU s a case"]
    return table(["machine", "cases", *header], rows)


def instruments_page(outcomes: Sequence[Outcome]) -> str:
    """Of each kind of instruments: how often the answer was right, by what is hidden."""
    rows = []
    for name in sorted({o.case.instruments for o in outcomes}):
        own = [o for o in outcomes if o.case.instruments == name]
        kinds = [[mark(o).right for o in own if o.case.kind == kind] for kind in _KINDS]
        rows.append([name, *(f"{sum(right)} of {len(right)}" if right else ABSENT for right in kinds)])
    return table(["instruments", *_KINDS.values()], rows)


def effects_page(outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> str:
    """Each hidden effect of each machine: how often it was judged right, what was answered, and how exactly."""
    rows = []
    for key in dict.fromkeys((o.case.machine, o.case.hidden, o.truths) for o in outcomes):
        own = [o for o in outcomes if (o.case.machine, o.case.hidden, o.truths) == key]
        errors = [error for o in own for error in parameter_errors(o, parameter_aliases).values()]
        rows.append(
            [
                key[0],
                " + ".join(key[2]) or key[1],
                f"{sum(mark(o).right for o in own)} of {len(own)}",
                _range([o.chi2_base for o in own]),
                _range([o.chi2 for o in own]),
                percent(max(errors)) if errors else ABSENT,
                number(sum(o.cpu for o in own) / len(own), 3),
                _answers(own),
            ]
        )
    header = ["machine", "hidden", "right", "χ² calibrated", "χ² after", "largest error", "CPU s", "answered"]
    return table(header, sorted(rows))


def misses_page(report: BenchmarkReport) -> str:
    """Every wrong answer with its cause."""
    rows = [
        [
            f"{row.machine}, {row.instruments}, seed {row.seed}",
            row.truth,
            row.verdict + (f": {row.answer}" if row.answer else ""),
            row.cause,
        ]
        for row in report.misses
    ]
    return table(["case", "hidden", "answered", "cause"], rows) or "None."


def report_page(report: BenchmarkReport, outcomes: Sequence[Outcome], parameter_aliases: Aliases) -> Page:
    """The whole report."""
    sections = [
        Section("figures", "Figures", rates_page(report)),
        Section("machines", "Machines", machines_page(report)),
        Section("instruments", "Instruments", instruments_page(outcomes)),
        Section("misses", "Misses", misses_page(report)),
        Section("effects", "Hidden effects", effects_page(outcomes, parameter_aliases)),
        Section("confusion", "Confusion", "![hidden against answered](confusion.png)"),
    ]
    return Page(f"Benchmark: {report.cases} cases", _lead(report), sections)


def _lead(report: BenchmarkReport) -> str:
    """How often the effect was found, and how often one was named where there is none."""
    told = [
        f"{said}: {_share(rate)} ({percent(rate.share)})"
        for name in ("top_1", "both_found", "false_alarm")
        for said, rate in [(SAID[name], report.rates[name])]
        if rate is not None
    ]
    sentence = "; ".join(told)
    return f"**{sentence[:1].upper()}{sentence[1:]}.**" if told else ""


def _figure(report: BenchmarkReport, name: str) -> tuple[str, str, str]:
    """Value, interval and number of cases of a figure."""
    if name in report.medians:
        value = report.medians[name]
        return (percent(value) if "error" in name else number(value)), "", ""
    rate = report.rates[name]
    if rate is None:
        return ABSENT, "", ""
    return (
        percent(rate.share),
        f"{percent(rate.low)} … {percent(rate.high)}",
        f"{rate.count} of {rate.of}",
    )


def _share(rate: Rate | None) -> str:
    return ABSENT if rate is None else f"{rate.count} of {rate.of}"


def _answers(outcomes: Sequence[Outcome]) -> str:
    """What was answered, most frequent first, each with how often."""
    said = [" + ".join(" or ".join(g) for g in o.found) or _nothing(o) for o in outcomes]
    counted = sorted({answer: said.count(answer) for answer in said}.items(), key=lambda pair: -pair[1])
    return "; ".join(answer if count == len(said) else f"{answer} ({count})" for answer, count in counted)


def _nothing(outcome: Outcome) -> str:
    """An answer without an effect: its verdict, and whether it lists what is hidden."""
    listed = bool(outcome.truths) and set(outcome.truths) <= set(outcome.absorbed)
    return f"{outcome.verdict}, absorbed and listed" if listed else outcome.verdict


def _range(values: Sequence[float]) -> str:
    low, high = number(min(values), 3), number(max(values), 3)
    return low if low == high else f"{low} … {high}"
