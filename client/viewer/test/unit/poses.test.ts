import {Matrix4} from 'three';
import {expect, test} from 'vitest';
import {boxText, visible} from '../../src/region';
import {Backoff} from '../../src/retry';
import {fromHeading, headingDeg, matrix, pose, withHeading} from '../../src/scene/poses';
import {mapTransform, odomTransform} from '../../src/tools/align';

const placement = (m: Matrix4) => ({component: 0, pose: pose(m)});

function close(a: Matrix4, b: Matrix4): void {
  a.elements.forEach((value, i) => expect(value).toBeCloseTo(b.elements[i]!, 9));
}

test('what is laid in the map is told between the odom frames, and back', () => {
  const a = placement(fromHeading(3, -2, 1, 40));
  const b = placement(fromHeading(-7, 5, 0.5, -100));
  const laid = fromHeading(12, 8, -0.2, 63);
  const told = matrix(odomTransform(a, laid, b));
  close(mapTransform(a, told, b), laid);
  // T_map_a_odom_a * T_odom_a_odom_b = T_map_a_map_b * T_map_b_odom_b.
  close(matrix(a.pose).multiply(told), laid.clone().multiply(matrix(b.pose)));
});

test('a heading is set and read, where it stands', () => {
  const turned = withHeading(fromHeading(1, 2, 3, 10), -170);
  expect(headingDeg(turned)).toBeCloseTo(-170, 9);
  expect(pose(turned).translation).toEqual({x: 1, y: 2, z: 3});
});

test('box and slice together show what lies in both', () => {
  const box = {min: {x: 0, y: 0, z: 0}, max: {x: 1, y: 2, z: 10}};
  const state = {box, clip: true, slice: true, sliceZ: 3, sliceM: 2.5};
  expect(visible(state)).toEqual({min: {x: 0, y: 0, z: 3}, max: {x: 1, y: 2, z: 5.5}});
  expect(visible({...state, slice: false})).toEqual(box);
  expect(visible({...state, slice: false, clip: false})).toBeUndefined();
  expect(boxText(box)).toBe('0.000,0.000,0.000,1.000,2.000,10.000');
});

test('attempts come ever more slowly, never slower than every 10 s, and when asked to', () => {
  const backoff = new Backoff();
  expect([1, 2, 3, 4, 5, 6, 7].map(() => backoff.delayMs())).toEqual(
      [500, 1000, 2000, 4000, 8000, 10000, 10000]);
  backoff.reset();
  expect(backoff.delayMs(3)).toBe(3000);
});
