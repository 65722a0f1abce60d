"""The numbers of the documentation, each from the command that computes it: `make claims`."""
