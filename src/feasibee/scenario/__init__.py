"""What to simulate: fields, their rules, presets, users' strategies, and whether the tasks are feasible."""
