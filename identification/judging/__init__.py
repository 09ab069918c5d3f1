"""How far a fit is to be believed: faults, verdict, coverage, uncertainty, bands."""
