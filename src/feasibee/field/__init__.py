"""A swarm as processes: one world, one process for each robot, messages between them."""
