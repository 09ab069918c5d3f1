"""Certified fits: each returns certified, dissipative models of one kind only."""
