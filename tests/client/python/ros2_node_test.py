"""The node for ROS 2, with stand-ins for rclpy and the messages, against a real server."""
import array
import importlib.util
import sys
import threading
import types
import unittest
from pathlib import Path
from typing import Any, Dict, List
from unittest import mock

import numpy as np

import isthmus
from isthmus import Pose
from servers import Server, scans

NODE = Path(__file__).resolve().parents[3] / "client" / "python" / "examples" / "ros2_node.py"
NUMBERS = {"f4": 7, "u2": 4, "u4": 6, "f8": 8}


class Message:
    """Any message: attributes appear when they are touched."""

    def __getattr__(self, name: str) -> Any:
        value = Message()
        setattr(self, name, value)
        return value


class Time:
    def __init__(self, nanoseconds: int = 0) -> None:
        self.nanoseconds = nanoseconds

    @classmethod
    def from_msg(cls, message: Any) -> "Time":
        return cls(message.sec * 10**9 + message.nanosec)

    def to_msg(self) -> Any:
        message = Message()
        message.sec, message.nanosec = divmod(self.nanoseconds, 10**9)
        return message


class Node:
    """What the node uses of rclpy's; `parameters` are what a launch file would set."""

    parameters: Dict[str, Any] = {}

    def __init__(self, name: str) -> None:
        self.defaults: Dict[str, Any] = {}
        self.published: List[Any] = []
        self.subscriptions: Dict[str, Any] = {}
        self.log: List[str] = []

    def declare_parameter(self, name: str, default: Any) -> None:
        self.defaults[name] = default

    def get_parameter(self, name: str) -> Any:
        return types.SimpleNamespace(value=self.parameters.get(name, self.defaults[name]))

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        return types.SimpleNamespace(publish=self.published.append)

    def create_subscription(self, kind: Any, topic: str, callback: Any, qos: Any) -> None:
        self.subscriptions[topic] = callback

    def get_logger(self) -> Any:
        return types.SimpleNamespace(info=self.log.append, warning=self.log.append,
                                     error=self.log.append)


class Broadcaster:
    def __init__(self, node: Node) -> None:
        self.sent: List[Any] = []

    def sendTransform(self, message: Any) -> None:  # pylint: disable=invalid-name
        self.sent.append(message)


def stand_ins() -> Dict[str, types.ModuleType]:
    modules = {}
    for name, content in (
            ("rclpy", {"init": lambda: None}), ("rclpy.node", {"Node": Node}),
            ("rclpy.qos", {"qos_profile_sensor_data": object()}), ("rclpy.time", {"Time": Time}),
            ("tf2_ros", {"TransformBroadcaster": Broadcaster}),
            ("geometry_msgs", {}), ("geometry_msgs.msg", {"TransformStamped": Message}),
            ("nav_msgs", {}), ("nav_msgs.msg", {"Odometry": Message}),
            ("sensor_msgs", {}), ("sensor_msgs.msg", {"PointCloud2": Message})):
        modules[name] = types.ModuleType(name)
        vars(modules[name]).update(content)
    return modules


def cloud_message(scan: isthmus.Scan) -> Any:
    points = scan.points
    message = types.SimpleNamespace(
        height=1, width=len(points), is_bigendian=False, point_step=points.dtype.itemsize,
        row_step=points.nbytes, data=array.array("B", points.tobytes()),
        fields=[types.SimpleNamespace(name=name, offset=points.dtype.fields[name][1], count=1,
                                      datatype=NUMBERS[points.dtype[name].str[1:]])
                for name in points.dtype.names])
    message.header = types.SimpleNamespace(
        frame_id="velodyne", stamp=Time(scan.stamp_ns - 10**8).to_msg())
    return message


def pose_of(place: Any, turn: Any) -> np.ndarray:
    return Pose((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)).matrix()


class NodeTest(unittest.TestCase):
    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.enterContext(mock.patch.dict(sys.modules, stand_ins()))
        spec = importlib.util.spec_from_file_location("ros2_node", NODE)
        assert spec is not None and spec.loader is not None
        self.module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(self.module)
        Node.parameters = {"server": self.server.address, "robot": "alice", "sensor": "vlp16",
                           "scan_seconds": 0.1}

    def drive(self, node: Any, count: int) -> None:
        """As many messages as the queue holds, each answered before the next."""
        answered = threading.Semaphore(0)
        publish = node.odometry.publish
        node.odometry.publish = lambda message: (publish(message), answered.release())
        for scan in scans(0)[:count]:
            node.subscriptions["points"](cloud_message(scan))
            self.assertTrue(answered.acquire(timeout=20))

    def test_publishes_where_the_robot_is(self) -> None:
        node = self.module.IsthmusNode()
        self.drive(node, 10)
        node.finish()
        with isthmus.connect(self.server.address) as client:
            stamps, poses = client.trajectory("alice", "odom")
        self.assertEqual(len(node.published), 10)
        for message, stamp, T_odom_sensor in zip(node.published, stamps, poses):
            self.assertEqual(Time.from_msg(message.header.stamp).nanoseconds, stamp)
            self.assertEqual((message.header.frame_id, message.child_frame_id),
                             ("odom", "velodyne"))
            pose = message.pose.pose
            np.testing.assert_allclose(pose_of(pose.position, pose.orientation), T_odom_sensor,
                                       atol=1e-6)
            self.assertEqual(len(message.pose.covariance), 36)
        np.testing.assert_array_equal(stamps, [scan.stamp_ns for scan in scans(0)[:10]])
        self.assertEqual({(t.header.frame_id, t.child_frame_id) for t in node.tf.sent},
                         {("odom", "velodyne")})  # It has no submap, so no place yet.
        self.assertIn("alice-1: 10 scans", node.log[-1])

    def test_publishes_map_to_odom_once_placed_and_new_frames_of_segments(self) -> None:
        node = self.module.IsthmusNode()
        self.drive(node, 1)
        ack = next(node.stream.acks())
        T_map_odom = Pose((5, 6, 7), (0, 0, 1, 0))
        node.tf.sent.clear()
        changed = {**vars(ack), "T_map_odom": T_map_odom, "segment": 2}
        node.on_ack(isthmus.Ack(**changed))
        to_sensor, to_map = node.tf.sent
        self.assertEqual((to_sensor.header.frame_id, to_map.child_frame_id), ("odom_2", "odom_2"))
        self.assertEqual(to_map.header.frame_id, "map")
        np.testing.assert_allclose(
            pose_of(to_map.transform.translation, to_map.transform.rotation), T_map_odom.matrix())
        node.finish()

    def test_says_what_it_cannot_use(self) -> None:
        node = self.module.IsthmusNode()
        broken = cloud_message(scans(0)[0])
        broken.fields = broken.fields[:2]
        node.subscriptions["points"](broken)
        self.assertIn("no field z", node.log[-1])
        empty = cloud_message(isthmus.Scan(10**9, scans(0)[0].points[:0]))
        node.subscriptions["points"](empty)
        node.finish()
        self.assertIn("REJECTED", node.log[-2])


if __name__ == "__main__":
    unittest.main()
