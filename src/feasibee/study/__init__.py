"""Studies: many scenarios, many runs of each, kept in a journal that survives anything."""
