"""Check the numbers of the documentation against the commands that compute them: `make claims`."""
