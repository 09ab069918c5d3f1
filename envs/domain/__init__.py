"""What differs between episodes: levels, and the draws of each episode."""
