"""Notes: one line for all files of which the same is said, and every one of them in the log."""

from facezip.character.notes import Note, lines, say


def test_files_of_which_the_same_is_said_share_a_line():
    notes = [Note("a.png", "turned upright"), Note("b.png", "turned upright"), Note("c.obj", "moved by one tile")]
    assert lines(notes) == ["a.png and 1 more: turned upright", "c.obj: moved by one tile"]


def test_every_line_is_a_warning_that_names_the_character(caplog):
    notes = [Note("a.png", "turned upright"), Note("c.obj", "moved by one tile")]
    say("ada", notes)
    assert [record.getMessage() for record in caplog.records] == [f"ada: {line}" for line in lines(notes)]
    assert {record.levelname for record in caplog.records} == {"WARNING"}
