"""feasibee_ros: a package for colcon (ament_python), and for pip alone."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "feasibee_ros"
SHARE = f"share/{NAME}"

setup(
    name=NAME,
    version="0.1.0",
    description="Robots that decide together whether they can do the tasks they see: feasibee on ROS 2.",
    license="Apache-2.0",
    packages=find_packages(include=[f"{NAME}*"]),
    package_data={NAME: ["fastdds.xml"]},
    python_requires=">=3.11",
    install_requires=["feasibee"],
    extras_require={
        # ROS 2 without an installation of ROS: wheels for Python 3.11.
        "wheels": [
            "ros-diagnostic-msgs==5.5.1",
            "ros-geometry-msgs==5.5.1",
            "ros-nav-msgs==5.5.1",
            "ros-rclpy==9.1.2",
            "ros-rmw-fastrtps-cpp==9.3.3",
            "ros-rosidl-typesupport-fastrtps-c==3.8.1",
            "ros-rosidl-typesupport-fastrtps-cpp==3.8.1",
            "ros-std-msgs==5.5.1",
        ],
        "test": ["mypy>=1.13", "pytest>=8.3"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/launch", [str(path) for path in Path("launch").glob("*.py")]),
    ],
    entry_points={
        "console_scripts": [
            "feasibee_robot = feasibee_ros.robot:main",
            "feasibee_field_robot = feasibee_ros.simulated:join",
        ]
    },
    zip_safe=False,
)
