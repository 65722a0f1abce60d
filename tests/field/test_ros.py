"""What the package says of nodes of ROS 2 without having them; ros2/tests runs the nodes."""

from __future__ import annotations

import pytest
from commands import refused_in_a_line


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ((), "--ros: needs ROS 2 and feasibee_ros"),
        (("--port", "7400"), "--ros with an address or a key"),
        (("--host", "0.0.0.0"), "--ros with an address or a key"),
    ],
)
def test_nodes_need_their_package_and_no_address(options, problem):
    assert problem in refused_in_a_line("launch", "--ros", *options)
