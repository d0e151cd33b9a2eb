// Reads a LAS file with the LAS reader of the npm package copc, and its system with proj4.
// Usage: node check_las.mjs FILE POINTS [LATITUDE LONGITUDE], in a folder with copc and proj4. With
// a place: the middle of the file must lie within a kilometre of it.
import copc from "copc";
import fs from "node:fs";
import proj4 from "proj4";

const { Las } = copc;
const [path, points, latitude, longitude] = process.argv.slice(2);
const bytes = fs.readFileSync(path);
const fail = (why) => {
  console.error(`${path}: ${why}`);
  process.exit(1);
};

const header = Las.Header.parse(bytes);
if (header.majorVersion !== 1 || header.minorVersion !== 4) fail("not LAS 1.4");
if (header.pointDataRecordFormat !== 6) fail(`point format ${header.pointDataRecordFormat}`);
if (header.pointCount !== Number(points)) fail(`${header.pointCount} points, not ${points}`);
const start = header.pointDataOffset;
const end = start + header.pointCount * header.pointDataRecordLength;
if (end !== bytes.length) fail(`${bytes.length} bytes, the header says ${end}`);
const view = Las.View.create(bytes.subarray(start, end), header);
const robots = new Set();
view.dimensions.PointSourceId || fail("no point source");
const source = view.getter("PointSourceId");
["X", "Y", "Z"].forEach((name, axis) => {
  const at = view.getter(name);
  let least = Infinity;
  let most = -Infinity;
  for (let i = 0; i < header.pointCount; ++i) {
    least = Math.min(least, at(i));
    most = Math.max(most, at(i));
    if (axis === 0) robots.add(source(i));
  }
  if (Math.abs(least - header.min[axis]) > 1e-6 || Math.abs(most - header.max[axis]) > 1e-6) {
    fail(`${name} is ${least} to ${most}, the header says ${header.min[axis]} to ${header.max[axis]}`);
  }
});
const vlrs = await Las.Vlr.walk(async (from, to) => bytes.subarray(from, to), header);
const wkt = Las.Vlr.find(vlrs, "LASF_Projection", 2112);
let where = "in the map's frame";
if (latitude !== undefined) {
  if (!wkt) fail("no coordinate system");
  const text = bytes.subarray(wkt.contentOffset, wkt.contentOffset + wkt.contentLength - 1);
  const middle = [0, 1].map((axis) => (header.min[axis] + header.max[axis]) / 2);
  const [lon, lat] = proj4(text.toString(), "WGS84").forward(middle);
  const metres = Math.hypot(lat - latitude, (lon - longitude) * Math.cos((lat * Math.PI) / 180)) * 111e3;
  if (!(metres < 1000)) fail(`its middle is at ${lat}, ${lon}`);
  where = `at ${lat.toFixed(5)}, ${lon.toFixed(5)}`;
} else if (wkt) {
  fail("a coordinate system without a datum");
}
console.log(`las: ${header.pointCount} points of ${robots.size} robots, ${where}`);
