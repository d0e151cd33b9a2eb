// Reads an MCAP file with MCAP's own reader and decodes every message by the schemas in the file.
// Usage: node check_mcap.mjs FILE POINTS, in a folder with @mcap/core and protobufjs.
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import descriptor from "protobufjs/ext/descriptor/index.js";
import fs from "node:fs";
import protobuf from "protobufjs";

const [path, points] = process.argv.slice(2);
const bytes = fs.readFileSync(path);
const fail = (why) => {
  console.error(`${path}: ${why}`);
  process.exit(1);
};

const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, size) =>
    new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
};
const reader = await McapIndexedReader.Initialize({ readable });
const types = new Map();
for (const schema of reader.schemasById.values()) {
  const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
  types.set(schema.id, root.lookupType(schema.name));
}
const counts = new Map();
let inClouds = 0;
let before = 0n;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const decoded = types.get(channel.schemaId).decode(message.data);
  if (decoded.data) inClouds += decoded.data.length / decoded.point_stride;
  if (message.logTime < before) fail("messages are not in order of time");
  before = message.logTime;
  counts.set(channel.topic, (counts.get(channel.topic) ?? 0) + 1);
}
const total = [...counts.values()].reduce((sum, count) => sum + count, 0);
if (BigInt(total) !== reader.statistics.messageCount) fail("the statistics count otherwise");
if (inClouds !== Number(points)) fail(`${inClouds} points in the clouds, not ${points}`);

// From front to back, which checks the checksums of chunks.
const stream = new McapStreamReader({ validateCrcs: true });
stream.append(bytes);
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) streamed += record.type === "Message" ? 1 : 0;
if (!stream.done() || streamed !== total) fail(`${streamed} of ${total} messages when streamed`);
console.log(`mcap: ${total} messages:`, Object.fromEntries(counts));
