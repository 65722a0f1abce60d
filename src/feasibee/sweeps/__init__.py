"""Run studies: plans, journals, workers, and tables of the results."""
