"""What a learner sees and gets: observation, reward, info, and a reward of its own."""
