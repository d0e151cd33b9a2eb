import {expect, test} from 'vitest';
import {readRobotPlace, readSession, readSubmap, type RobotPlace, type Session, type Submap}
  from '../../src/api/messages';
import {newestSession, placeOf} from '../../src/robots';

const at = (x: number) => ({translation: {x, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}});
const session = (id: string, robot: string, opened = id): Session =>
  readSession({id, robot, firstSegment: opened === id ? '' : opened});
const submap = (id: string, index: number, component?: number): Submap =>
  readSubmap({session: id, index, ...(component === undefined ? {} : {component, tMapSubmap: at(index)})});
const now = (robot: string, id: string, component?: number): RobotPlace => readRobotPlace({
  robot, session: id, ...(component === undefined ? {} : {component, tMapSensor: at(50)}),
  ...(id ? {} : {localising: {state: 'LOCATED', scans: 1}}),
});

const sessions = [session('alice-1', 'alice'), session('bob-1', 'bob'), session('alice-2', 'alice')];
const submaps = [submap('alice-1', 0, 0), submap('alice-1', 1, 0), submap('alice-2', 0, 1),
                 submap('alice-2', 1, 1), submap('alice-2', 2)];

test('of a robot in two maps the newest session answers, not the one in the larger map', () => {
  const newest = newestSession('alice', sessions);
  expect(newest?.id).toBe('alice-2');
  expect(placeOf('alice', newest, [], submaps)).toEqual({component: 1, pose: at(1)});
  // Nor does an older one that is still open.
  expect(placeOf('alice', newest, [now('alice', 'alice-1', 0)], submaps)?.component).toBe(1);
});

test('of a session the last segment answers', () => {
  const segments = [...sessions, session('alice-2.2', 'alice', 'alice-2')];
  expect(newestSession('alice', segments)?.id).toBe('alice-2.2');
});

test('a robot that is under way is where its newest scan was', () => {
  const newest = newestSession('alice', sessions);
  expect(placeOf('alice', newest, [now('alice', 'alice-2', 1)], submaps))
      .toEqual({component: 1, pose: at(50)});
  // The last submap that has a place answers if the session has none now.
  expect(placeOf('alice', newest, [now('alice', 'alice-2')], submaps)?.pose).toEqual(at(1));
});

test('a robot that is localised is where it is found, with sessions of its own or without', () => {
  const newest = newestSession('alice', sessions);
  expect(placeOf('alice', newest, [now('alice', '', 0)], submaps)?.component).toBe(0);
  expect(placeOf('guest', undefined, [now('guest', '', 1)], submaps)?.component).toBe(1);
  expect(placeOf('guest', undefined, [now('guest', '')], submaps)).toBe(undefined);
});

test('one whose newest session has no submap in a map is in none', () => {
  const newest = newestSession('bob', sessions);
  expect(placeOf('bob', newest, [now('bob', 'bob-1')], submaps)).toBe(undefined);
});
