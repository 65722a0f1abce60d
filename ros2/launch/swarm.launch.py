"""Start n robots in namespaces /robot_0, /robot_1 and so on; all say and hear one topic, /radio."""

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode

from launch import LaunchDescription

ARGUMENTS = {
    "n": ("2", "number of robots on this machine"),
    "first": ("0", "number of the first of them"),
    "scenario": ("", "file of the scenario; by default the paper's"),
    "detections": ("poses", "poses, or objects in JSON"),
    "params": ("", "YAML file with parameters of all of them"),
    "radio": ("/radio", "topic of the swarm's messages"),
}


def swarm(context):
    """Return the nodes."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    own = {"scenario": given["scenario"], "detections": given["detections"]}
    first = int(given["first"])
    return [
        LifecycleNode(
            package="feasibee_ros",
            executable="feasibee_robot",
            name="feasibee",
            namespace=f"/robot_{number}",
            parameters=[own, *([given["params"]] if given["params"] else [])],
            remappings=[("heard", given["radio"]), ("said", given["radio"])],
            output="screen",
        )
        for number in range(first, first + int(given["n"]))
    ]


def generate_launch_description():
    """Return what `ros2 launch feasibee_ros swarm.launch.py n:=5` starts."""
    told = [
        DeclareLaunchArgument(name, default_value=value, description=text)
        for name, (value, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*told, OpaqueFunction(function=swarm)])
