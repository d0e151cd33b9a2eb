import {expect, test} from 'vitest';
import {withoutOverlap} from '../../src/scene/labels';

test('of labels that lie on each other the first is shown', () => {
  const at = (x: number, y: number) => ({x, y, width: 60, height: 20});
  expect(withoutOverlap([at(0, 0), at(30, 10), at(60, 0), at(0, 20), at(59, 19)]))
      .toEqual([true, false, true, true, false]);
});

test('one that is hidden hides none', () => {
  const at = (x: number) => ({x, y: 0, width: 60, height: 20});
  expect(withoutOverlap([at(0), at(40), at(80)])).toEqual([true, false, true]);
});
