"""Definitions shared by all other packages: codes, purposes of draws, outcomes and records."""
