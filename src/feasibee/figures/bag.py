"""Bags: one run, step by step, as a bag of ROS 2 that Foxglove and RViz show."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from PIL.ImageColor import getrgb

from feasibee.errors import FeasibeeError, how_to_install
from feasibee.files import atomic_write, named
from feasibee.model.codes import COLOURS, DECISIONS, TASK
from feasibee.scenario.plan import Plan
from feasibee.scenario.scenario import Scenario
from feasibee.simulation.frames import Shown

STEP: Final = 0.1  # seconds, unless the scenario has units.seconds
START: Final = 10**9  # nanoseconds at step 0: in ROS, a time of 0 means none
ROBOTS_LIMIT: Final = 1_000  # each has two topics
WALL, NO_GO = 100, 50  # values of cells of the map; open cells have 0
CUBE, CYLINDER, DELETE = 1, 3, 2  # shapes of markers, and the action that removes one
LOOKS: Final = ((TASK, 0.3), (TASK, 1.0), (COLOURS["undecided"], 0.3))  # of tasks: free, taken, done


class Bag:
    """A bag to which a run of a scenario is written; each message has the time of its step.

    Raise a FeasibeeError if the scenario has too many robots, or rosbags is missing.
    """

    def __init__(self, scenario: Scenario, path: Path) -> None:
        self.seconds, self.metres = scenario.units.seconds or STEP, scenario.units.metres or 1.0
        if scenario.most.robots > ROBOTS_LIMIT:
            rule = f"a bag has topics for at most {ROBOTS_LIMIT:,} robots"
            raise FeasibeeError(f"{named(path)}: {rule}; use fewer robots, or feasibee animate")
        if self.seconds * scenario.run.steps > 2 * 10**9:
            rule = "ROS has 31 bits for the seconds of a time; use a smaller units.seconds"
            raise FeasibeeError(f"{named(path)}: {rule}, or fewer steps")
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise FeasibeeError(f"{named(path)}: needs rosbags; {how_to_install('bag')}") from None
        self.scenario, self.path = scenario, path
        self.store = get_typestore(Stores.ROS2_HUMBLE)  # later versions have the same messages
        self.ways, self.shown = dict[str, Any](), {"robots": set[int](), "tasks": set[int]()}
        self.corner = scenario.place.map.origin if scenario.place.map else (0.0, 0.0)

    def write(self, swarm: Shown, last: int, progress: Callable[[float], None]) -> None:
        """Write a swarm, or the recording of a field, from its present step to the last one.

        The same run gives the same bytes. Raise a FeasibeeError if the file can't be written.
        """
        from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

        self.swarm = swarm
        with atomic_write(self.path) as file, TemporaryDirectory(prefix=".bag-", dir=file.parent) as made:
            folder = Path(made) / "bag"  # rosbags writes a folder, with metadata in addition
            self.writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
            self.writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            with self.writer:
                for step in range(swarm.step, last + 1):
                    swarm.advance(step - swarm.step)
                    self.write_step()
                    progress((step + 1) / (last + 1))
            (folder / "bag.mcap").replace(file)

    def write_step(self) -> None:
        """Write the present step: the map once, then poses, opinions, frames and markers."""
        self.time = START + round(1e9 * self.seconds * self.swarm.step)
        self.header = {"stamp": {"sec": self.time // 10**9, "nanosec": self.time % 10**9}, "frame_id": "map"}
        if self.scenario.plan is not None and "/map" not in self.ways:
            self.write_map(self.scenario.plan)
        self.write_robots()
        self.write_tasks()

    def put(self, topic: str, kind: str, **fields: Any) -> None:
        """Write a message; late subscribers get the map, too."""
        if topic not in self.ways:
            options: dict[str, Any] = {"offered_qos_profiles": [_latched()] if topic == "/map" else []}
            self.ways[topic] = self.writer.add_connection(topic, kind, typestore=self.store, **options)
        data = self.store.serialize_cdr(_message(self.store, kind, fields), kind)
        self.writer.write(self.ways[topic], self.time, data)

    def pose(self, at: Iterable[float], heading: float = 0.0) -> dict[str, dict[str, float]]:
        """Return the pose of a position in units, in metres and in the frame of the map's file."""
        x, y = (float(low + self.metres * each) for low, each in zip(self.corner, at, strict=True))
        turn = {"z": float(np.sin(heading / 2)), "w": float(np.cos(heading / 2))}
        return {"position": {"x": x, "y": y}, "orientation": turn}

    def write_map(self, plan: Plan) -> None:
        """Write the floor plan."""
        cells = np.where(plan.walls, WALL, np.where(plan.keepout, NO_GO, 0)).astype(np.int8)
        info = {"resolution": float(plan.cell) * self.metres, "origin": self.pose((0.0, 0.0))}
        info |= {"height": cells.shape[0], "width": cells.shape[1]}
        self.put("/map", "nav_msgs/msg/OccupancyGrid", header=self.header, info=info, data=cells.ravel())

    def write_robots(self) -> None:
        """Write pose and opinion of each robot, and the frames and markers of all."""
        swarm, frames, markers = self.swarm, [], {}
        at, headings, opinions = swarm.positions, swarm.headings, swarm.opinions.tolist()
        for robot in np.flatnonzero(swarm.present).tolist():
            name, pose = f"robot_{robot}", self.pose(at[robot], headings[robot])
            self.put(f"/{name}/pose", "geometry_msgs/msg/PoseStamped", header=self.header, pose=pose)
            self.put(f"/{name}/opinion", "std_msgs/msg/Int8", data=opinions[robot])
            move = {"translation": pose["position"], "rotation": pose["orientation"]}
            frames.append({"header": self.header, "child_frame_id": name, "transform": move})
            markers[robot] = pose, COLOURS[DECISIONS[opinions[robot]]], 1.0
        self.put("/tf", "tf2_msgs/msg/TFMessage", transforms=frames)
        self.put_markers("robots", CYLINDER, markers)

    def write_tasks(self) -> None:
        """Write the markers of the tasks."""
        looks = self.swarm.acting.looks if self.scenario.acts else np.ones(len(self.swarm.tasks), np.uint8)
        shown = zip(self.swarm.task_numbers.tolist(), self.swarm.tasks, looks, strict=True)
        self.put_markers("tasks", CUBE, {number: (self.pose(at), *LOOKS[look]) for number, at, look in shown})

    def put_markers(self, group: str, shape: int, shown: Mapping[int, tuple[Any, str, float]]) -> None:
        """Write a marker for each robot or task, and remove those that a viewer may still show."""
        side = self.scenario.robots.diameter * self.metres
        of = {"header": self.header, "ns": group, "pose": self.pose((0.0, 0.0))}
        of["scale"] = {"x": side, "y": side, "z": side / 2}
        markers = []
        for number, (pose, colour, opacity) in shown.items():
            look = dict(zip("rgba", (*(each / 255 for each in getrgb(colour)), opacity), strict=True))
            markers.append({**of, "id": number, "type": shape, "pose": pose, "color": look})
        gone = sorted(self.shown[group] - shown.keys())
        self.shown[group] |= shown.keys()
        markers += [{**of, "id": each, "action": DELETE} for each in gone]
        self.put(f"/{group}", "visualization_msgs/msg/MarkerArray", markers=markers)


def _message(store: Any, kind: str, fields: Mapping[str, Any]) -> Any:
    """Return a message of rosbags with these fields; all others are zero or empty."""
    values = {name: _value(store, form, fields.get(name)) for name, form in store.fielddefs[kind][1]}
    return store.types[kind](**values)


def _value(store: Any, form: Any, given: Any) -> Any:
    """Return the value of a field, by its form in rosbags."""
    node, of = form
    if node.name == "NAME":
        return _message(store, of, given or {})
    if node.name != "BASE" and of[0][0].name == "NAME":
        return [_message(store, of[0][1], each) for each in given or ()]
    empty = {"string": "", "bool": False}.get(of[0], 0) if node.name == "BASE" else np.zeros(0, of[0][1][0])
    return empty if given is None else given


def _latched() -> Any:
    """Return the quality of service of a topic whose last message late subscribers get."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    kept = QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL
    never = QosTime(0, 0)
    return Qos(*kept, never, never, QosLiveliness.AUTOMATIC, never, False)
