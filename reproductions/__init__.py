"""Papers that are repeated, one program a paper: `make reproduce` runs all of them, shortened."""
