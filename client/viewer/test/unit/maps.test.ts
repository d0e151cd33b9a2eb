import {expect, test} from 'vitest';
import type {Component} from '../../src/api/messages';
import {numberNow} from '../../src/maps';

function map(component: number, ...sessions: string[]): Component {
  return {component, referenceSession: sessions[0]!, sessions, robots: [], points: 1, bounds: undefined};
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
