"""The machine that runs many scenarios many times: plans, journals, workers, tables."""
