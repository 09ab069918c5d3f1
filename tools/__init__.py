"""Programs for developers: they remake shipped files and pages of the docs."""
