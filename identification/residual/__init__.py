"""The residual of a fit: noise of the torque, and what the model does not describe."""
