"""Robots that decide together whether they can do the tasks they see, as nodes of ROS 2."""
