"""The words, numbers and records that every other room agrees on: codes, purposes of draws, outcomes."""
