import {expect, test} from 'vitest';
import type {Component} from '../../src/api/messages';
import {mapTitle, numberNow} from '../../src/maps';

function map(component: number, ...sessions: string[]): Component {
  return {component, referenceSession: sessions[0]!, sessions, robots: [], pointCount: 1, bounds: undefined};
}

test('the map that is shown stays when a larger one comes', () => {
  const shown = map(0, 'alice-1', 'bob-1');
  expect(numberNow(shown, [map(0, 'eve-1', 'eve-2', 'eve-3'), map(1, 'alice-1', 'bob-1')])).toBe(1);
  expect(numberNow(shown, [map(0, 'eve-1'), map(1, 'carol-1', 'alice-1')])).toBe(1);
});

test('it goes on by what is left of it where its reference is deleted', () => {
  expect(numberNow(map(0, 'alice-1', 'bob-1'), [map(0, 'eve-1'), map(1, 'bob-1')])).toBe(1);
  expect(numberNow(map(2, 'alice-1'), [map(0, 'eve-1')])).toBe(0);
  expect(numberNow(undefined, [])).toBe(0);
});

test('two maps of the same robot are told apart by the name that stays', () => {
  const title = (component: number, ...robots: string[]) =>
      mapTitle({...map(component, `${robots[0]}-${component + 1}`), robots});
  expect(title(0, 'alice')).toBe('Map 0 (alice-1): alice');
  expect(title(1, 'alice')).toBe('Map 1 (alice-2): alice');
  expect(title(0, 'a', 'b', 'c', 'd', 'e')).toBe('Map 0 (a-1): a, b, c and 2 more');
});
