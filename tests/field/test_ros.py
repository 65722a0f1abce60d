"""What the package says of nodes of ROS 2 without having them; ros2/tests runs the nodes."""

from __future__ import annotations

from commands import refused_in_a_line


def test_nodes_need_their_package():
    assert "--ros: needs ROS 2 and feasibee_ros" in refused_in_a_line("robot", "launch", "--ros")
