"""The questions: what to run, what to compute, and what to say."""
