from dr_lab.comparison.fault_notes import fault_notes, faults_markdown, known_faults, lines_markdown
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.reports.faults import faults_line, faults_told
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import Log, MeasurementSet, Note


def test_faults_are_told_once_for_each_signal_with_all_logs() -> None:
    frozen = Note("fault", "arm.position", "Frozen: arm.position repeats one value from 1.00 to 2.00 s.", 500)
    logs = (Log("a", {}, {}, (Note("gap", "arm.position", "arm.position: 1 gap."), frozen)), Log("b", {}, {}))
    measured = MeasurementSet("m", logs, (), {}, {})
    faults = tuple(Fault("sign", log, "motor", 0.1, 4.9, "motor: turned.", "Write sign: -1.") for log in ("a", "b"))
    notes = fault_notes(faults, measured)
    assert [(note.fault, note.log) for note in notes] == [("sign", "a"), ("sign", "b"), ("frozen", "a")]
    assert "(0.10 to 4.90 s) Write sign: -1." in notes[0].message
    lines = faults_markdown(notes).splitlines()
    assert sum(line.startswith("- `a`: motor") for line in lines) == 1
    assert "The same in b." in "".join(lines)


def test_sound_logs_are_not_spoken_of() -> None:
    assert faults_markdown([NoteEntry("arm: 1 gap.", "gap")]) == ""


def test_what_is_allowed_for_need_not_be_mended() -> None:
    """Commands read as lines between their samples, and a velocity that is left out."""
    frozen = Note("fault", "arm.velocity", "Frozen: arm.velocity repeats one value from 1.00 to 2.00 s.", 500)
    allowed = (Note("unlogged", "motor", "motor: read as lines."), Note("derived", "arm.velocity", "it is left out."))
    logs = tuple(Log(name, {}, {}, (frozen, *allowed)) for name in "ab")
    faults = [Fault("decimated", log, "motor", 0.1, 4.9, "motor: logged rarely.", "Log more.") for log in "ab"]
    notes = known_faults(faults, MeasurementSet("m", logs, (), {}, {}))
    told = faults_markdown(notes)
    assert "mend this first" not in told
    assert told.startswith("What is wrong with the logs is allowed for here:\n\n- `a`: motor: logged rarely.")
    assert faults_line(notes) == "decimated motor (2 logs, allowed for), frozen arm.velocity (2 logs, allowed for)"
    turned = Fault("sign", "a", "motor", 0.1, 4.9, "motor: turned.", "Write sign: -1.")
    both = known_faults([*faults, turned], MeasurementSet("m", logs, (), {}, {}))
    first, second = faults_markdown(both).split("What is wrong")
    assert "mend this first, the rest depends on it:**\n\n- `a`: motor: turned." in first
    assert "logged rarely" not in first
    assert "logged rarely" in second
    assert "), sign motor (1 log), " in faults_line(both)


def test_commands_that_stay_as_they_were_logged_are_to_be_mended() -> None:
    fault = Fault("decimated", "a", "motor", 0.1, 4.9, "motor: logged rarely.", "Log more.")
    notes = known_faults([fault], MeasurementSet("m", (Log("a", {}, {}),), (), {}, {}))
    assert "mend this first" in faults_markdown(notes)
    assert faults_line(notes) == "decimated motor (1 log)"


def test_what_is_to_be_mended_comes_first_in_a_sentence() -> None:
    faults = [Fault("sign", log, "motor", 0.1, 4.9, "motor: turned.", "Write sign: -1.") for log in "ab"]
    logs = tuple(Log(name, {}, {}) for name in "ab")
    notes = known_faults(faults, MeasurementSet("m", logs, (), {}, {}))
    assert faults_told(notes).startswith("**The logs seem faulty:** sign motor (2 logs). Mend this first")
    assert faults_told([]) == ""
    derived = (Note("derived", "motor", "motor: it is left out."),)
    allowed = MeasurementSet("m", tuple(Log(name, {}, {}, derived) for name in "ab"), (), {}, {})
    assert faults_told(known_faults(faults, allowed)) == ""


def test_commands_read_as_lines_without_a_fault_are_told_once() -> None:
    notes = [NoteEntry(f"{name}: it goes on between.", "unlogged", signal=name) for name in ("a", "b", "a", "b")]
    assert lines_markdown(notes) == "How commands are read:\n\n- a: it goes on between. The same of b."
    fault = NoteEntry("a: too rare.", "fault", fault="decimated", log="log", signal="a")
    assert lines_markdown([fault, notes[0]]) == ""
    assert lines_markdown([]) == ""
