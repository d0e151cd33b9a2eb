// Writes PTS2: for the mock server and for tests of what reads it.
export function pts2(points, robots) {
  const axes = ['x', 'y', 'z'];
  const origin = axes.map((axis) => points.reduce((low, p) => Math.min(low, p[axis]), Infinity));
  const top = axes.map((axis) => points.reduce((high, p) => Math.max(high, p[axis]), -Infinity));
  const scale = axes.map((_, i) => Math.max(top[i] - origin[i], 1e-9) / 65535);
  const count = points.length;
  const stampsAt = 56 + 8 * count;
  const bytes = Buffer.alloc(stampsAt + 5 * count);
  bytes.write('PTS2');
  bytes.writeUInt32LE(count, 4);
  axes.forEach((_, i) => {
    bytes.writeDoubleLE(count ? origin[i] : 0, 8 + 8 * i);
    bytes.writeDoubleLE(count ? scale[i] : 1, 32 + 8 * i);
  });
  points.forEach((p, n) => {
    axes.forEach((axis, i) => bytes.writeUInt16LE(
        Math.round((p[axis] - origin[i]) / scale[i]), 56 + 6 * n + 2 * i));
    bytes[56 + 6 * count + n] = Math.round(Math.min(Math.max(p.intensity, 0), 255));
    bytes[56 + 7 * count + n] = Math.min(Math.max(robots.indexOf(p.robot), 0), 255);
    bytes.writeUInt32LE(p.stamp, stampsAt + 4 * n);
    bytes[stampsAt + 4 * count + n] = p.label ?? 0;
  });
  return bytes;
}
