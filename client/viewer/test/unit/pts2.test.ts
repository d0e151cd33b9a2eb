import {expect, test} from 'vitest';
import {parsePts2} from '../../src/tiles/pts2';
// @ts-expect-error plain JavaScript, of the mock server.
import {pts2} from '../../dev/pts2_writer.mjs';

function bytes(points: object[], robots: string[]): ArrayBuffer {
  const buffer = pts2(points, robots) as Uint8Array;
  return buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.byteLength) as ArrayBuffer;
}

const POINTS = [
  {x: -20, y: 3, z: 0, intensity: 7, robot: 'alice', stamp: 1_700_000_000, label: 9},
  {x: 0, y: 23, z: 4, intensity: 300, robot: 'bob', stamp: 0},
  {x: -7.25, y: 11.5, z: 1.125, intensity: -1, robot: 'bob', stamp: 4_000_000_000},
];

test.each([0, 1, 2, 3])('reads %i points as they were written', (count) => {
  const parsed = parsePts2(bytes(POINTS.slice(0, count), ['alice', 'bob']));
  expect(parsed.count).toBe(count);
  POINTS.slice(0, count).forEach((point, i) => {
    [point.x, point.y, point.z].forEach((value, axis) => {
      const read = parsed.origin[axis]! + parsed.scale[axis]! * parsed.positions[3 * i + axis]!;
      expect(Math.abs(read - value)).toBeLessThan(0.0002);
    });
    expect(parsed.intensities[i]).toBe(Math.min(Math.max(point.intensity, 0), 255));
    expect(parsed.robots[i]).toBe(point.robot === 'bob' ? 1 : 0);
    expect(parsed.stamps[i]).toBe(point.stamp);
    expect(parsed.classes[i]).toBe(point.label ?? 0);
  });
});

test('refuses what is cut off, longer, or something else', () => {
  const whole = bytes(POINTS, ['alice', 'bob']);
  expect(() => parsePts2(whole.slice(0, 40))).toThrow(/header/);
  expect(() => parsePts2(whole.slice(0, whole.byteLength - 4))).toThrow(/bytes for 3 points/);
  const other = whole.slice(0);
  new Uint8Array(other)[3] = 0x31;
  expect(() => parsePts2(other)).toThrow(/not PTS2/);
  const many = whole.slice(0);
  new DataView(many).setUint32(4, 0xffffffff, true);
  expect(() => parsePts2(many)).toThrow(/bytes for/);
});
