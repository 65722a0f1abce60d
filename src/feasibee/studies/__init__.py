"""The questions that are asked of swarms: the paper's, comparisons, assessments, tuning, sensitivity."""
