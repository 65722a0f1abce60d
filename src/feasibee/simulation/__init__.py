"""Simulate many runs at once, or one swarm step by step, with the engine or the reference."""
