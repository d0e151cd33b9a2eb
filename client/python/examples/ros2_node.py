#!/usr/bin/python3
"""A ROS 2 node that pushes a LiDAR's PointCloud2 messages, and publishes where the robot is.

UNTESTED ON ROS 2: Debian 12 has none. It is tested with stand-ins for rclpy and the messages.

Subscribes `points`; publishes `odometry` (nav_msgs/Odometry, odom -> sensor frame, pose only) and
on tf odom -> sensor frame (which must have no other parent) and, once the robot is placed,
map -> odom. Parameters: `server`, `robot`, `sensor`, `scan_seconds` (to be added to stamps: 0.0 if
the driver stamps the END of a scan, the duration of a turn if it stamps the first point).
"""
import isthmus
import rclpy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import PointCloud2


class IsthmusNode(Node):
    def __init__(self):
        super().__init__("isthmus")
        for name, default in (("server", "127.0.0.1:50051"), ("robot", "robot"),
                              ("sensor", "spinning"), ("scan_seconds", 0.0)):
            self.declare_parameter(name, default)
        value = {name: self.get_parameter(name).value
                 for name in ("server", "robot", "sensor", "scan_seconds")}
        self.turn_ns = round(value["scan_seconds"] * 1e9)
        self.sensor_frame = "lidar"
        self.odometry = self.create_publisher(Odometry, "odometry", 10)
        self.tf = tf2_ros.TransformBroadcaster(self)
        self.client = isthmus.connect(value["server"])
        session = self.client.create_session(value["robot"], value["sensor"])
        # A callback must not wait: when the link is too slow the newest scan is dropped. An hour
        # out of reach of the server is survived.
        self.stream = self.client.open_stream(session, window=32, when_full="drop_newest",
                                              keep_trying_s=3600, on_ack=self.on_ack)
        self.create_subscription(PointCloud2, "points", self.on_points, qos_profile_sensor_data)

    def on_points(self, cloud):
        self.sensor_frame = cloud.header.frame_id
        stamp_ns = Time.from_msg(cloud.header.stamp).nanoseconds + self.turn_ns
        try:
            if not self.stream.push(stamp_ns, cloud):
                self.get_logger().warning("a scan was dropped: the link is too slow")
        except isthmus.InvalidArgument as error:
            self.get_logger().error(f"a scan cannot be sent: {error}")

    def on_ack(self, ack):
        """Called by the stream's thread; publishing is thread safe."""
        if ack.T_odom_sensor is None:
            self.get_logger().warning(f"scan {ack.sequence}: {ack.outcome} {ack.reason}")
            return
        stamp = Time(nanoseconds=ack.stamp_ns).to_msg()
        # Each segment of a session has an odom frame of its own: poses begin anew in it.
        odom = "odom" if ack.segment <= 1 else f"odom_{ack.segment}"
        message = Odometry()
        message.header.stamp, message.header.frame_id = stamp, odom
        message.child_frame_id = self.sensor_frame
        put(ack.T_odom_sensor, message.pose.pose.position, message.pose.pose.orientation)
        covariance = ack.covariance_in_odom()
        if covariance is not None:
            message.pose.covariance = covariance.ravel().tolist()
        self.odometry.publish(message)
        self.send(stamp, odom, self.sensor_frame, ack.T_odom_sensor)
        if ack.T_map_odom is not None:
            self.send(stamp, "map", odom, ack.T_map_odom)

    def send(self, stamp, parent, child, pose):
        message = TransformStamped()
        message.header.stamp, message.header.frame_id = stamp, parent
        message.child_frame_id = child
        put(pose, message.transform.translation, message.transform.rotation)
        self.tf.sendTransform(message)

    def finish(self):
        session = self.stream.finish_session()
        self.get_logger().info(f"{session.id}: {session.last_sequence} scans")
        self.client.close()


def put(pose, place, turn):
    place.x, place.y, place.z = map(float, pose.translation)
    turn.x, turn.y, turn.z, turn.w = map(float, pose.quaternion)


def main():
    rclpy.init()
    node = IsthmusNode()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    node.finish()


if __name__ == "__main__":
    main()
