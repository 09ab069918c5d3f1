"""Programs for the developers: they remake what ships with the package, and check its prose."""
