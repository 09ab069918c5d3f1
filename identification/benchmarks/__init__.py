"""Published benchmarks of identification.

The dispatch benchmark of Kao and Fung (2009), their piezo mechanism, and the Bouc-Wen benchmark of
the system identification community.
"""
