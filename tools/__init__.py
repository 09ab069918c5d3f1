"""Programs for developers: they remake shipped files and check the prose of docstrings."""
