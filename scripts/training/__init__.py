"""Training of policies: learners, checkpoints, evaluations during a training, distillation."""
