"""Fits of our own: each returns certified, dissipative models of one kind only."""
