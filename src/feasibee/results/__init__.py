"""Outcomes with names and units, and the statistics of decisions."""
