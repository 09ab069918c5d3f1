"""What the residual of a fit says: how noisy the torque is, and what no model described."""
