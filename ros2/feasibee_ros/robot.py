"""A robot as a lifecycle node: its senses and what it hears go in, its messages and its opinion come out."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32, Header, Int8, String, UInt8MultiArray

from feasibee.base.codes import DECISIONS
from feasibee.base.errors import FeasibeeError
from feasibee.field.node import HEARD_LIMIT, Node
from feasibee_ros.messages import frame_from, frame_message, goal_at, report
from feasibee_ros.senses import OBJECTS, POSES, Senses

if TYPE_CHECKING:
    from feasibee.scenario.scenario import Scenario

KEPT = QoSProfile(depth=1000)
"""Reliable; so many messages of a swarm wait for a busy robot."""
LATEST = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes later gets the newest message."""
LOGGED = QoSProfile(depth=100_000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Who comes later gets the log from its first line on."""
HEARS = {"odom": Odometry, "robots": PoseArray, "tasks": PoseArray, OBJECTS: String, "heard": UInt8MultiArray}
"""What a robot subscribes to; the parameter ``topics.NAME`` gives a topic another name."""
SAYS = {
    "said": UInt8MultiArray,
    "opinion": Int8,
    "declaration": Int8,
    "confidence": Float32,
    "status": DiagnosticArray,
    "goal_pose": PoseStamped,
}
"""What it publishes."""
DIAGNOSED = 1.0
"""Seconds between two diagnostics."""


class Robot(LifecycleNode):
    """One robot. Configured, it has a mind; active, it steps by its own clock.

    Topics and parameters are those of docs/ros.md.
    """

    defaults: ClassVar[dict[str, Any]] = {
        "id": -1,
        "scenario": "",
        "seed": -1,
        "hz": 0.0,
        "detections": POSES,
        "stale": 1.0,
    }
    """The robot's own parameters."""

    def __init__(self, name: str = "feasibee", **options: Any) -> None:
        super().__init__(name, **options)
        self.problem = ""
        """Why it couldn't be configured or take part."""
        self.status = 0
        """Its exit status."""
        self.has_ended = False
        """Whether it has nothing to do any more."""
        for parameter, default in {**self.defaults, "autostart": True}.items():
            self.declare_parameter(parameter, default)
        self.declare_parameter("set", None, ParameterDescriptor(dynamic_typing=True))
        for topic in {**HEARS, **SAYS, "log": String}:
            self.declare_parameter(f"topics.{topic}", topic)
        self._made: list[tuple[Callable[[Any], Any], Any]] = []
        self._clocks: list[Any] = []
        self.mind: Node | None = None

    def value(self, parameter: str) -> Any:
        """Return the value of a parameter."""
        return self.get_parameter(parameter).value

    def start(self) -> None:
        """Configure and activate it, unless somebody else does; it ends if it can't be configured."""
        if not self.value("autostart"):
            return
        self.trigger_configure()
        if self.problem:
            self.status, self.has_ended = 2, True
        else:
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give it a number, topics and a mind."""
        self.problem = ""
        try:
            self.number = _number(self.value("id"), self.get_namespace())
            self.configure()
        except FeasibeeError as error:
            self.problem = str(error)
            self.get_logger().error(self.problem)
            self._remove()
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start the robot's clock."""
        done = super().on_activate(state)
        self.set_out()
        return done

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop its clock; its mind stays."""
        self._stop_clocks()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove the robot's mind and topics."""
        self._remove()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove the robot's mind and topics, and end the robot."""
        self._remove()
        self.has_ended = True
        return super().on_shutdown(state)

    def configure(self) -> None:
        """Make the topics and the mind of a robot that has its parameters."""
        from feasibee.field.senses import real_robot  # heavy, and not for simulated robots
        from feasibee.simulation.flooding import flooded

        self._make_publishers()
        scenario = flooded(self._scenario())
        seed, hz, detections = (self.value(name) for name in ("seed", "hz", "detections"))
        if detections not in (POSES, OBJECTS):
            raise FeasibeeError(f"detections = {detections}: must be {POSES} or {OBJECTS}")
        if detections == POSES and scenario.sensing.observation == "unique":
            raise FeasibeeError(
                f'sensing.observation = "unique": poses have no names; set detections to {OBJECTS}'
            )
        self.mind = real_robot(scenario, self.number, None if seed < 0 else seed, self.keep)
        self.reach = scenario.acting.reach
        self.period = 1.0 / hz if hz > 0 else scenario.units.seconds or 0.1
        self.sense_with(Senses(scenario.units.metres or 1.0, detections))

    def _scenario(self) -> Scenario:
        """Return the scenario with the changes of ``set``, and the ``decision.FIELD`` that differ."""
        from feasibee.cli.options import GivenScenario
        from feasibee.scenario.fields import SECTIONS
        from feasibee.scenario.paths import read_value

        file = self.value("scenario")
        base = GivenScenario(Path(file) if file else None, tuple(self.value("set") or ())).read()
        held, changes = base.to_dict()["decision"], {}
        for field in SECTIONS["decision"].model_fields:
            name = f"decision.{field}"
            plain = _plain(held.get(field))
            if not self.has_parameter(name):
                self.declare_parameter(name, plain, ParameterDescriptor(dynamic_typing=True))
            value = self.value(name)
            if value != plain:
                changes[name] = read_value(value) if isinstance(value, str) else value
        return base.replace(changes)

    def _make_publishers(self) -> None:
        """Make a publisher for each topic."""
        self.topics = {
            name: self.publisher(kind, self.value(f"topics.{name}")) for name, kind in SAYS.items()
        }
        # Not of the lifecycle: its first line comes before the robot is active.
        self._log = self.create_publisher(String, self.value("topics.log"), LOGGED)
        self._made.append((self.destroy_publisher, self._log))
        self._diagnostics = self.publisher(DiagnosticArray, "/diagnostics")
        self._heard: list[list[Any]] = []
        self._goal: Any = None
        self.step, self._is_in_step = 0, False
        self._said: str | None = None

    def publisher(self, kind: Any, topic: str) -> Any:
        """Return a publisher of its own, which is silent while the robot is inactive."""
        made = self.create_lifecycle_publisher(kind, topic, KEPT)
        self._made.append((self.destroy_lifecycle_publisher, made))
        return made

    def listen(self, kind: Any, topic: str, take: Callable[[Any], None], qos: QoSProfile = KEPT) -> Any:
        """Return a subscription of its own."""
        made = self.create_subscription(kind, topic, take, qos)
        self._made.append((self.destroy_subscription, made))
        return made

    def sense_with(self, senses: Senses) -> None:
        """Subscribe to odometry and detections, and to other robots."""
        self.senses = senses
        self._sensed_at = dict.fromkeys(senses.takers, self._now)
        takers = {name: self._sensing(name, take) for name, take in senses.takers.items()}
        takers["heard"] = self.take_frame
        self.ears = [self.listen(HEARS[name], self.value(f"topics.{name}"), takers[name]) for name in takers]

    def _sensing(self, name: str, take: Callable[[Any], None]) -> Callable[[Any], None]:
        def sense(message: Any) -> None:
            take(message)
            self._sensed_at[name] = self._now
            self.has_sensed()

        return sense

    def has_sensed(self) -> None:
        """Do nothing: a robot with a clock of its own waits for it."""

    @property
    def _now(self) -> float:
        """Seconds of the node's clock."""
        return float(self.get_clock().now().nanoseconds) / 1e9

    def each(self, seconds: float, tick: Callable[[], None]) -> Any:
        """Start a clock that stops when the robot is deactivated."""
        timer = self.create_timer(seconds, tick)
        self._clocks.append(timer)
        return timer

    def _stop_clocks(self) -> None:
        for timer in self._clocks:
            self.destroy_timer(timer)
        self._clocks = []

    def _remove(self) -> None:
        self._stop_clocks()
        for destroy, made in self._made:
            destroy(made)
        self._made, self.mind = [], None

    def set_out(self) -> None:
        """Begin to step."""
        self.each(self.period, self.tick)
        self.each(DIAGNOSED, self.diagnose)

    @property
    def silent(self) -> dict[str, float]:
        """Topics of senses that say nothing, with the seconds since they last did."""
        ages = {name: self._now - at for name, at in self._sensed_at.items()}
        return {name: age for name, age in ages.items() if age > self.value("stale")}

    def tick(self) -> None:
        """End the step that it is in, and begin the next one; old detections don't count any more."""
        for name in self.silent:
            self.senses.forget(name)
        if self._is_in_step:
            self.end()
        self.begin(self.step + 1)

    def begin(self, step: int) -> None:
        """Begin a step: say the message of it, and look around."""
        mind = self.mind
        assert mind is not None
        self.step, self._is_in_step = step, True
        self._said = mind.speak(step, self.senses.place, self.senses.insight())
        mind.sense(self.senses.sensed(mind.goes, self._arrival()))
        self.say()

    def say(self) -> None:
        """Publish the message of this step, if there is one."""
        if self._said is not None:
            self.topics["said"].publish(frame_message(self.number, self.step, self._said))

    def end(self) -> None:
        """End a step with what it heard, and tell what it holds."""
        assert self.mind is not None
        heard, self._heard = self._heard, []
        self.mind.finish(heard)
        self._is_in_step = False
        self.tell()

    def _arrival(self) -> list[list[Any]]:
        """Return what its body has done: it may have reached its goal."""
        way = self.mind.way if self.mind is not None else {}
        return self.senses.arrived(way["go"], self.reach) if way.get("go") and not way["stand"] else []

    def take_frame(self, message: UInt8MultiArray) -> None:
        """Keep a message of another robot for the end of this step."""
        frame = frame_from(message)
        if self.mind is None or frame is None or len(self._heard) >= HEARD_LIMIT:
            if self.mind is not None:
                self.mind.dropped["malformed message" if frame is None else "too many messages"] += 1
        else:
            self.take(*frame)

    def take(self, sender: int, _: int, text: str) -> None:
        """Keep a message, unless it is its own."""
        if sender != self.number:
            self._heard.append([sender, text])

    def keep(self, line: Any) -> None:
        """Publish a line of its log, as `feasibee robot replay` reads it from a file."""
        self._log.publish(String(data=json.dumps(line, separators=(",", ":"))))

    def tell(self) -> None:
        """Publish what it holds, and where it goes."""
        mind = self.mind
        assert mind is not None
        status = mind.status
        self.topics["opinion"].publish(Int8(data=status.opinion))
        self.topics["declaration"].publish(Int8(data=status.declared))
        self.topics["confidence"].publish(Float32(data=mind.confidence))
        self.tell_status()
        go = mind.way.get("go")
        if go and go != self._goal:
            header = Header(stamp=self.get_clock().now().to_msg(), frame_id=self.senses.frame)
            self.topics["goal_pose"].publish(goal_at(go, header, self.senses.metres))
        self._goal = go

    def tell_status(self) -> None:
        """Publish all that it holds."""
        self.topics["status"].publish(self.held(self.get_clock().now().to_msg()))

    def held(self, stamp: Any, warning: str = "", **more: Any) -> DiagnosticArray:
        """Return all that it holds, as diagnostics."""
        mind = self.mind
        assert mind is not None
        values = {
            **mind.status._asdict(),
            "step": self.step,
            "confidence": mind.confidence,
            "goes": mind.goes,
        }
        header = Header(stamp=stamp, frame_id=self.senses.frame)
        return report(header, self.number, DECISIONS[mind.status.opinion], {**values, **more}, warning)

    def diagnose(self) -> None:
        """Publish diagnostics; warn of senses that say nothing."""
        assert self.mind is not None
        ages = [f"{name} for {age:.0f} s" for name, age in self.silent.items()]
        warning = f"silent: {', '.join(ages)}; check the topics" if ages else ""
        if self.senses.foreign:
            warning = f"poses in frame {self.senses.foreign}: publish them in {self.senses.frame}"
        dropped = {**self.mind.dropped, "invalid detections": self.senses.dropped}
        self._diagnostics.publish(self.held(self.get_clock().now().to_msg(), warning, dropped=dropped))


def _plain(value: Any) -> Any:
    """Return a value of a scenario as that of a parameter: text in TOML, if parameters have no such type."""
    from feasibee.scenario.paths import inline_toml

    if value is None:
        return ""
    return value if isinstance(value, bool | int | float | str) else inline_toml(value)


def _number(given: int, namespace: str) -> int:
    """Return a robot's number: that of the parameter, or else the one at the end of its namespace."""
    found = re.search(r"(\d+)$", namespace)
    if given >= 0:
        return given
    if found is None:
        raise FeasibeeError(f"id: namespace {namespace} ends with no number; set id, or use __ns:=/robot_3")
    return int(found[1])


def spin(node: Robot) -> None:
    """Run a robot until it ends."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        node.start()
        while not node.has_ended:
            executor.spin_once()


USAGE = """One robot of a swarm as a node of ROS 2; docs/ros.md lists its topics and parameters.

Example:
  {program} --ros-args -r __ns:=/robot_3 -r heard:=/radio -r said:=/radio -p scenario:=hall.toml
"""


def main(kind: type[Robot] = Robot, usage: str = USAGE) -> None:
    """Run one robot until it is shut down; its exit status is 2 if something that it was given is wrong."""
    if {"-h", "--help"} & {*sys.argv[1:]}:
        print(usage.format(program=Path(sys.argv[0]).name), end="")
        return
    try:
        with rclpy.init():
            robot = kind()
            spin(robot)
    except FeasibeeError as error:  # of the machine, such as a full disk
        sys.exit(f"feasibee: {error}")
    sys.exit(robot.status)


if __name__ == "__main__":
    main()
