from dr_lab.comparison.fault_notes import fault_notes, faults_markdown
from dr_lab.diagnosis.faults.data_faults import Fault
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
