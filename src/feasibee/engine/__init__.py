"""The model, compiled."""
