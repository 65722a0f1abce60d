"""Studies: the paper, robustness, comparison, assessment, tuning, sensitivity."""
