"""Training of policies: learners, their checkpoints, evaluations between, and distillation."""
