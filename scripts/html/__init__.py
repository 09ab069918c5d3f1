"""report.html of a run: one page that works offline, made from the files of the run folder."""
