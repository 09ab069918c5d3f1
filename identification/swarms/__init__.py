"""Optimizers of any function of a few bounded parameters: the published swarms."""
