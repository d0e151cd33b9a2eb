import {expect, test} from 'vitest';
import {isCut, visible, type RegionState} from '../../src/region';
import {findCeiling} from '../../src/scene/ceiling';

type Height = (x: number, y: number) => number;

// A level or sloping surface over [0, w) x [0, d), a point every `step` metres.
function surface(w: number, d: number, z: Height, step = 0.2): number[] {
  const points = [];
  for (let x = 0; x < w; x += step) for (let y = 0; y < d; y += step) points.push(x, y, z(x, y));
  return points;
}

// Along y, from the floor to `high`.
function wall(x: number, d: number, high: number, step = 0.2): number[] {
  const points = [];
  for (let y = 0; y < d; y += step) for (let z = -1; z < high; z += step) points.push(x, y, z);
  return points;
}

const floor = (w: number, d: number) => surface(w, d, () => -1);

test('a hall is cut under its roof', () => {
  const hall = [...floor(30, 20), ...wall(0, 20, 5), ...wall(29, 20, 5), ...surface(30, 20, () => 5)];
  const cut = findCeiling(hall, 0);
  expect(cut).toBeGreaterThan(4.4);
  expect(cut).toBeLessThan(4.95);
});

test('so is one of which coarse points are shown', () => {
  const coarse = [...surface(200, 200, () => -1, 1.6), ...surface(200, 200, () => 6, 1.6),
                  ...wall(0, 200, 6, 1.6)];
  expect(findCeiling(coarse, 0)).toBeCloseTo(5.7, 1);
});

test('of two storeys the upper one is opened, as robots drove there', () => {
  const slab = surface(20, 20, () => 2);
  const house = [...floor(20, 20), ...slab, ...surface(20, 20, () => 5)];
  expect(findCeiling(house, 3)).toBeCloseTo(4.7, 1);
});

test('where there is no ceiling nothing is cut', () => {
  const walls = Array.from({length: 15}, (_, i) => wall(2 * i, 20, 3)).flat();
  expect(findCeiling([...floor(30, 20), ...walls], 0)).toBeUndefined();
  // A hill, and a shed on a large yard.
  expect(findCeiling(surface(60, 60, (x) => x / 4), 14)).toBeUndefined();
  expect(findCeiling([...floor(60, 60), ...surface(10, 10, () => 3)], 0)).toBeUndefined();
  // A deck above a street that robots drove on, too.
  expect(findCeiling([...floor(30, 30), ...surface(30, 30, () => 4)], 5)).toBeUndefined();
  expect(findCeiling([], 0)).toBeUndefined();
});

test('a slice or a box to clip to says what is shown, else the ceiling is cut unless asked for', () => {
  const state: RegionState = {box: undefined, clip: false, slice: false, sliceZ: 0, sliceM: 2.5,
                              ceilingZ: 4, lid: false};
  expect(visible(state)?.max.z).toBe(4);
  expect(visible({...state, lid: true})).toBeUndefined();
  expect(visible({...state, ceilingZ: undefined})).toBeUndefined();
  expect(visible({...state, slice: true, sliceZ: 3})?.max.z).toBe(5.5);
  expect(isCut({...state, slice: true})).toBe(false);
  const box = {min: {x: 0, y: 0, z: 0}, max: {x: 1, y: 1, z: 9}};
  expect(visible({...state, box, clip: true})).toEqual(box);
  expect(visible({...state, box})?.max.z).toBe(4);
});
