"""The compiled simulation engine: it works on numbers and arrays, and knows no scenario."""
