"""The door to the engine and the reference: many runs at once, or one swarm step by step."""
