#!/usr/bin/python3
"""Writes the ROS 1 bags of the readers' tests with ROS' own library.

Usage: make_bags.py
Needs Debian's python3-rosbag, python3-sensor-msgs and python3-tf2-msgs. What is in them is in
drive_formulas.h, which the tests compare with, and in make_mcap.mjs.
"""
import pathlib
import struct

import genpy
import genpy.dynamic
import rosbag
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import NavSatFix, PointCloud2, PointField
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

HERE = pathlib.Path(__file__).resolve().parent
START_NS = 1_700_000_000_000_000_000
LINE = "=" * 80
HEADER = f"{LINE}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"


def dynamic(name, text):
    return genpy.dynamic.generate_dynamic(name, text)[name]


VelodyneScan = dynamic(
    "velodyne_msgs/VelodyneScan",
    f"Header header\nVelodynePacket[] packets\n{HEADER}{LINE}\n"
    "MSG: velodyne_msgs/VelodynePacket\ntime stamp\nuint8[1206] data\n")
PacketMsg = dynamic("ouster_ros/PacketMsg", "uint8[] buf\n")
CustomMsg = dynamic(
    "livox_ros_driver2/CustomMsg",
    "Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
    f"CustomPoint[] points\n{HEADER}{LINE}\n"
    "MSG: livox_ros_driver2/CustomPoint\nuint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
    "uint8 reflectivity\nuint8 tag\nuint8 line\n")
VelodynePacket = genpy.dynamic.generate_dynamic(
    "velodyne_msgs/VelodynePacket", "time stamp\nuint8[1206] data\n")["velodyne_msgs/VelodynePacket"]
CustomPoint = dynamic("livox_ros_driver2/CustomPoint",
                      "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
                      "uint8 reflectivity\nuint8 tag\nuint8 line\n")
# The definitions would be most of these small bags, and no reader looks at them.
for kind in (NavSatFix, PointCloud2, String, TFMessage, VelodyneScan, PacketMsg, CustomMsg):
    kind._full_text = "left out"


def time(ns):
    return genpy.Time(ns // 10**9, ns % 10**9)


def stamped(message, ns, frame):
    message.header.stamp = time(ns)
    message.header.frame_id = frame
    return message


def field(name, offset, datatype, count=1):
    return PointField(name=name, offset=offset, datatype=datatype, count=count)


def cloud_a(k):
    """Rows that are padded, records with gaps, times in seconds from the start."""
    rows = b""
    for row in range(2):
        for i in range(3 * row, 3 * row + 3):
            rows += struct.pack("<ffff4xHxxf4x", 10 * (k + 1) + i, -i, 0.5 * i + k, 2 * i, row, 0.02 * i)
        rows += b"\xee" * 8
    cloud = PointCloud2(height=2, width=3, point_step=32, row_step=104, data=rows, is_dense=True)
    cloud.fields = [field("x", 0, 7), field("y", 4, 7), field("z", 8, 7), field("intensity", 12, 7),
                    field("ring", 20, 4), field("time", 24, 7)]
    return stamped(cloud, START_NS + k * 10**8, "lidar_a")


def cloud_b(k):
    """Big endian doubles, times in nanoseconds."""
    data = b"".join(struct.pack(">dddI", 100 * k + i, i / 8, -k, 30_000_000 * i) for i in range(4))
    cloud = PointCloud2(height=1, width=4, point_step=28, row_step=112, data=data, is_bigendian=True)
    cloud.fields = [field("x", 0, 8), field("y", 8, 8), field("z", 16, 8), field("t", 24, 6)]
    return stamped(cloud, START_NS + 20_000_000 + k * 10**8, "lidar_b")


def fix(k):
    message = NavSatFix(latitude=48 + 1e-5 * k, longitude=11 + 2e-5 * k, altitude=500 + k)
    message.status.status = -1 if k == 1 else 0
    message.position_covariance = [0.04, 0, 0, 0, 0.09, 0, 0, 0, 0.25]
    message.position_covariance_type = 0 if k == 2 else 2
    return stamped(message, START_NS + 50_000_000 + k * 10**8, "gps")


def transforms():
    edges = []
    for child, t, q in (("lidar_a", (1, 2, 3), (0, 0, 2, 2)), ("gps", (0, 0, 1.5), (0, 0, 0, 1))):
        edge = stamped(TransformStamped(child_frame_id=child), START_NS, "base")
        edge.transform.translation.x, edge.transform.translation.y, edge.transform.translation.z = t
        r = edge.transform.rotation
        r.x, r.y, r.z, r.w = q
        edges.append(edge)
    return TFMessage(transforms=edges)


def velodyne():
    packets = [VelodynePacket(stamp=time(START_NS + 10**8 + p * 10**6),
                              data=bytes((7 * j + p) & 255 for j in range(1206))) for p in range(2)]
    return stamped(VelodyneScan(packets=packets), START_NS + 10**8, "velodyne")


def livox(k):
    points = [CustomPoint(offset_time=50_000_000 * i, x=i + k, y=2 * i, z=3 * i, reflectivity=10 * i,
                          tag=i + 1, line=i) for i in range(3)]
    ns = START_NS + k * 10**8
    return stamped(CustomMsg(timebase=ns, point_num=3, lidar_id=1, rsvd=bytes(3), points=points), ns,
                   "livox")


def ouster(size, k):
    return PacketMsg(buf=bytes((3 * j + k) & 255 for j in range(size)))


def drive():
    messages = [(0, "/tf_static", transforms()), (0, "/os/metadata", String('{"beams": 16}'))]
    for k in range(3):
        ns = k * 10**8
        messages += [(ns + 105_000_000, "/a/points", cloud_a(k)), (ns + 120_000_000, "/b/points", cloud_b(k)),
                     (ns + 51_000_000, "/gps/fix", fix(k)), (ns + 30_000_000, "/chatter", String(f"hello {k}"))]
    for k in range(2):
        messages += [(300_000_000 + k * 10**6, "/os/lidar_packets", ouster(64, k)),
                     (k * 10**8 + 110_000_000, "/livox/lidar", livox(k))]
    messages += [(200_000_000, "/velodyne_packets", velodyne()),
                 (301_500_000, "/os/imu_packets", ouster(48, 0))]
    return sorted(messages, key=lambda message: message[0])


def main():
    for compression in ("none", "bz2", "lz4"):
        with rosbag.Bag(HERE / f"drive_{compression}.bag", "w", compression=compression,
                        chunk_threshold=1500) as bag:
            for log_ns, topic, message in drive():
                bag.write(topic, message, time(START_NS + log_ns))


if __name__ == "__main__":
    main()
