"""Results as labelled datasets with their recipe, and statistics of decisions."""
