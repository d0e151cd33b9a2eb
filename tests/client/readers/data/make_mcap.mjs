// Writes the MCAP files of the readers' tests with MCAP's own library, and the CDR messages that
// make_db3.py puts into databases.
//
// Usage: node make_mcap.mjs MESSAGES.jsonl
// Needs, from npm: @mcap/core@2 @foxglove/rosmsg @foxglove/rosmsg-serialization
// @foxglove/rosmsg2-serialization @foxglove/wasm-zstd protobufjs; and lz4(1). What is in them is in drive_formulas.h, which the tests compare
// with, and in make_bags.py.
import { execFileSync } from "node:child_process";
import { createWriteStream, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { createRequire } from "node:module";

const require = createRequire(join(process.cwd(), "node_modules", "x.js"));
const { McapWriter } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { MessageWriter: Ros1Writer } = require("@foxglove/rosmsg-serialization");
const zstd = require("@foxglove/wasm-zstd");
const protobuf = require("protobufjs");

const HERE = dirname(fileURLToPath(import.meta.url));
const START_NS = 1_700_000_000_000_000_000n;

const HEADER = `${"=".repeat(80)}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const DEFINITIONS = {
  "sensor_msgs/msg/PointCloud2": `std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
${HEADER}${"=".repeat(80)}
MSG: sensor_msgs/PointField
string name
uint32 offset
uint8 datatype
uint32 count
`,
  "sensor_msgs/msg/NavSatFix": `std_msgs/Header header
sensor_msgs/NavSatStatus status
float64 latitude
float64 longitude
float64 altitude
float64[9] position_covariance
uint8 position_covariance_type
${HEADER}${"=".repeat(80)}
MSG: sensor_msgs/NavSatStatus
int8 status
uint16 service
`,
  "std_msgs/msg/String": "string data\n",
  "tf2_msgs/msg/TFMessage": `geometry_msgs/TransformStamped[] transforms
${"=".repeat(80)}
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
${HEADER}${"=".repeat(80)}
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
${"=".repeat(80)}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
${"=".repeat(80)}
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
`,
  "velodyne_msgs/msg/VelodyneScan": `std_msgs/Header header
velodyne_msgs/VelodynePacket[] packets
${HEADER}${"=".repeat(80)}
MSG: velodyne_msgs/VelodynePacket
builtin_interfaces/Time stamp
uint8[1206] data
`,
  "ouster_sensor_msgs/msg/PacketMsg": "uint8[] buf\n",
  "livox_ros_driver2/msg/CustomMsg": `std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
livox_ros_driver2/CustomPoint[] points
${HEADER}${"=".repeat(80)}
MSG: livox_ros_driver2/CustomPoint
uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
`,
};
const WRITERS = Object.fromEntries(
  Object.entries(DEFINITIONS).map(([type, text]) => [type, new MessageWriter(parse(text, { ros2: true }))]));

const stampOf = (ns) => ({ sec: Number(ns / 1_000_000_000n), nanosec: Number(ns % 1_000_000_000n) });
const header = (ns, frame_id) => ({ stamp: stampOf(ns), frame_id });
const at = (ms) => START_NS + BigInt(ms) * 1_000_000n;
const field = (name, offset, datatype) => ({ name, offset, datatype, count: 1 });

function cloudA(k) {
  const data = Buffer.alloc(2 * 104, 0xee);
  for (let i = 0; i < 6; ++i) {
    const o = Math.floor(i / 3) * 104 + (i % 3) * 32;
    data.fill(0, o, o + 32);
    [10 * (k + 1) + i, -i, 0.5 * i + k, 2 * i].forEach((v, j) => data.writeFloatLE(v, o + 4 * j));
    data.writeUInt16LE(Math.floor(i / 3), o + 20);
    data.writeFloatLE(0.02 * i, o + 24);
  }
  return {
    header: header(at(100 * k), "lidar_a"), height: 2, width: 3, is_bigendian: false,
    point_step: 32, row_step: 104, data, is_dense: true,
    fields: [field("x", 0, 7), field("y", 4, 7), field("z", 8, 7), field("intensity", 12, 7),
             field("ring", 20, 4), field("time", 24, 7)],
  };
}

function cloudB(k) {
  const data = Buffer.alloc(4 * 28);
  for (let i = 0; i < 4; ++i) {
    [100 * k + i, i / 8, -k].forEach((v, j) => data.writeDoubleBE(v, 28 * i + 8 * j));
    data.writeUInt32BE(30_000_000 * i, 28 * i + 24);
  }
  return {
    header: header(at(20 + 100 * k), "lidar_b"), height: 1, width: 4, is_bigendian: true,
    point_step: 28, row_step: 112, data, is_dense: false,
    fields: [field("x", 0, 8), field("y", 8, 8), field("z", 16, 8), field("t", 24, 6)],
  };
}

const fix = (k) => ({
  header: header(at(50 + 100 * k), "gps"), status: { status: k === 1 ? -1 : 0, service: 1 },
  latitude: 48 + 1e-5 * k, longitude: 11 + 2e-5 * k, altitude: 500 + k,
  position_covariance: [0.04, 0, 0, 0, 0.09, 0, 0, 0, 0.25],
  position_covariance_type: k === 2 ? 0 : 2,
});

const edge = (child_frame_id, [x, y, z], [qx, qy, qz, qw]) => ({
  header: header(START_NS, "base"), child_frame_id,
  transform: { translation: { x, y, z }, rotation: { x: qx, y: qy, z: qz, w: qw } },
});

const bytes = (size, value) => Uint8Array.from({ length: size }, (_, j) => value(j) & 255);
const ouster = (size, k) => ({ buf: bytes(size, (j) => 3 * j + k) });

const velodyne = () => ({
  header: header(at(100), "velodyne"),
  packets: [0, 1].map((p) => ({ stamp: stampOf(at(100 + p)), data: bytes(1206, (j) => 7 * j + p) })),
});

const livox = (k) => ({
  header: header(at(100 * k), "livox"), timebase: at(100 * k), point_num: 3, lidar_id: 1, rsvd: [0, 0, 0],
  points: [0, 1, 2].map((i) => ({ offset_time: 50_000_000 * i, x: i + k, y: 2 * i, z: 3 * i,
                                  reflectivity: 10 * i, tag: i + 1, line: i })),
});

function drive() {
  const messages = [[0, "/tf_static", "tf2_msgs/msg/TFMessage",
                     { transforms: [edge("lidar_a", [1, 2, 3], [0, 0, 2, 2]), edge("gps", [0, 0, 1.5], [0, 0, 0, 1])] }],
                    [0, "/os/metadata", "std_msgs/msg/String", { data: '{"beams": 16}' }]];
  for (let k = 0; k < 3; ++k) {
    messages.push([100 * k + 105, "/a/points", "sensor_msgs/msg/PointCloud2", cloudA(k)],
                  [100 * k + 120, "/b/points", "sensor_msgs/msg/PointCloud2", cloudB(k)],
                  [100 * k + 51, "/gps/fix", "sensor_msgs/msg/NavSatFix", fix(k)],
                  [100 * k + 30, "/chatter", "std_msgs/msg/String", { data: `hello ${k}` }]);
  }
  for (let k = 0; k < 2; ++k) {
    messages.push([300 + k, "/os/lidar_packets", "ouster_sensor_msgs/msg/PacketMsg", ouster(64, k)],
                  [100 * k + 110, "/livox/lidar", "livox_ros_driver2/msg/CustomMsg", livox(k)]);
  }
  messages.push([200, "/velodyne_packets", "velodyne_msgs/msg/VelodyneScan", velodyne()],
                [302, "/os/imu_packets", "ouster_sensor_msgs/msg/PacketMsg", ouster(48, 0)]);
  return messages.sort((a, b) => a[0] - b[0]).map(([ms, topic, type, message]) =>
    ({ log: at(ms), topic, type, data: WRITERS[type].writeMessage(message) }));
}

// /a/points as ROS 1 serialises it.
function ros1() {
  const text = DEFINITIONS["sensor_msgs/msg/PointCloud2"]
    .replace("builtin_interfaces/Time stamp", "uint32 seq\ntime stamp");
  const writer = new Ros1Writer(parse(text));
  return [0, 1, 2].map((k) => {
    const cloud = cloudA(k);
    const { sec, nanosec } = cloud.header.stamp;
    cloud.header = { seq: k, stamp: { sec, nsec: nanosec }, frame_id: "lidar_a" };
    return { log: at(100 * k + 105), topic: "/a/points", type: "sensor_msgs/PointCloud2",
             data: writer.writeMessage(cloud) };
  });
}

// A file in memory, as McapWriter wants one.
class Sink {
  parts = [];
  size = 0n;
  position() { return this.size; }
  async write(part) { this.parts.push(Buffer.from(part)); this.size += BigInt(part.byteLength); }
}

async function writeMcap(name, messages, { encoding = "cdr", schemaEncoding = "ros2msg", ...options }) {
  const sink = new Sink();
  const writer = new McapWriter({ writable: sink, chunkSize: 1500, ...options });
  await writer.start({ profile: encoding === "cdr" ? "ros2" : "", library: "isthmus fixtures" });
  const channels = new Map();
  for (const { log, topic, type, data, schema } of messages) {
    if (!channels.has(topic)) {
      const schemaId = await writer.registerSchema(
        { name: type, encoding: schemaEncoding, data: schema ?? new TextEncoder().encode("left out") });
      channels.set(topic, await writer.registerChannel(
        { schemaId, topic, messageEncoding: encoding, metadata: new Map() }));
    }
    await writer.addMessage({ channelId: channels.get(topic), sequence: 0, logTime: log, publishTime: log, data });
  }
  await writer.addAttachment({ name: "note.txt", logTime: START_NS, createTime: START_NS,
                               mediaType: "text/plain", data: new TextEncoder().encode("hello") });
  await writer.end();
  writeFileSync(join(HERE, name), Buffer.concat(sink.parts));
}

function foxglove() {
  const root = protobuf.Root.fromJSON({ nested: {
    Time: { fields: { seconds: { id: 1, type: "int64" }, nanos: { id: 2, type: "int32" } } },
    Element: { fields: { name: { id: 1, type: "string" }, offset: { id: 2, type: "fixed32" },
                         type: { id: 3, type: "int32" } } },
    Vector3: { fields: { x: { id: 1, type: "double" } } },
    Pose: { fields: { position: { id: 1, type: "Vector3" } } },
    PointCloud: { fields: {
      timestamp: { id: 1, type: "Time" }, frameId: { id: 2, type: "string" }, pose: { id: 3, type: "Pose" },
      pointStride: { id: 4, type: "fixed32" }, fields: { id: 5, rule: "repeated", type: "Element" },
      data: { id: 6, type: "bytes" } } },
  } });
  const type = root.lookupType("PointCloud");
  return [0, 1].map((k) => {
    const data = Buffer.alloc(3 * 20);
    for (let i = 0; i < 3; ++i) {
      [i + k, 2 * i, 3 * i].forEach((v, j) => data.writeFloatLE(v, 20 * i + 4 * j));
      data.writeUInt16LE(i, 20 * i + 12);
      data.writeUInt32LE(50_000_000 * i, 20 * i + 16);
    }
    const element = (name, offset, kind) => ({ name, offset, type: kind });
    return { log: at(100 * k + 110), topic: "/fox", type: "foxglove.PointCloud", data: type.encode(type.fromObject({
      timestamp: { seconds: Number(at(100 * k) / 1_000_000_000n), nanos: Number(at(100 * k) % 1_000_000_000n) },
      frameId: "fox", pose: { position: { x: 5 } }, pointStride: 20, data,
      fields: [element("x", 0, 7), element("y", 4, 7), element("z", 8, 7), element("ring", 12, 3),
               element("t", 16, 5)],
    })).finish() };
  });
}

async function main() {
  await zstd.isLoaded;
  const messages = drive();
  const compress = {
    lz4: (data) => ({ compression: "lz4", compressedData: execFileSync("lz4", ["-c"], { input: data }) }),
    zstd: (data) => ({ compression: "zstd", compressedData: zstd.compress(data, 5) }),
  };
  const bare = { useStatistics: false, useSummaryOffsets: false, useChunkIndex: false, useMessageIndex: false,
                 repeatSchemas: false, repeatChannels: false, useMetadataIndex: false, useAttachmentIndex: false };
  await writeMcap("drive_none.mcap", messages, {});
  await writeMcap("drive_lz4.mcap", messages, { compressChunk: compress.lz4 });
  await writeMcap("drive_zstd.mcap", messages, { compressChunk: compress.zstd, schemaEncoding: "ros2idl" });
  await writeMcap("drive_bare.mcap", messages, { compressChunk: compress.zstd, ...bare });
  await writeMcap("drive_loose.mcap", messages, { useChunks: false, useStatistics: true });
  await writeMcap("foxglove.mcap", foxglove(), { encoding: "protobuf", schemaEncoding: "protobuf" });
  await writeMcap("ros1.mcap", ros1(), { encoding: "ros1", schemaEncoding: "ros1msg" });
  const lines = createWriteStream(process.argv[2]);
  for (const { log, topic, type, data } of messages) {
    lines.write(JSON.stringify({ log: String(log), topic, type, data: Buffer.from(data).toString("hex"),
                                 zstd: Buffer.from(zstd.compress(Buffer.from(data), 5)).toString("hex") }) + "\n");
  }
  lines.end();
}

await main();
