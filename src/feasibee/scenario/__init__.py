"""Scenarios: fields, rules, presets, users' strategies, ground truth, and which runs to simulate."""
