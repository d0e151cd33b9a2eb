import {expect, test} from 'vitest';
import {readPose} from '../../src/api/geometry';
import {readLoop, readMatch, readServerStatus, readSubmap, readWatchMapResponse}
  from '../../src/api/messages';
import {lines, RpcError} from '../../src/api/rpc';
import {isUndecided, poseOf, stateOf} from '../../src/api/views';

test('what is left out has its default', () => {
  expect(readMatch({})).toMatchObject({sessionA: '', state: '', reason: '', stages: [], inTree: false});
  expect(readMatch({}).tAB).toBeUndefined();
  expect(readPose({}).rotation).toEqual({x: 0, y: 0, z: 0, w: 1});
  expect(readServerStatus({}).sessions).toEqual([]);
  expect(readLoop({}).id).toBe(0);
});

test('component 0 is one, a missing one is none', () => {
  expect(readSubmap({component: 0}).component).toBe(0);
  expect(readSubmap({}).component).toBeUndefined();
  expect(readSubmap({component: null}).component).toBeUndefined();
});

test('64-bit integers come as text, numbers as either', () => {
  const submap = readSubmap({index: 3, pointCount: '9007199254740991', firstStampNs: '1700000000500000000'});
  expect(submap).toMatchObject({index: 3, pointCount: 9007199254740991, firstStampMs: 1700000000500});
  expect(readWatchMapResponse({run: '18446744073709551615'}).run).toBe('18446744073709551615');
});

test('enumerations that a newer server has are taken for unknown ones', () => {
  expect(readMatch({state: 'REJECTED', reason: 'REASON_FREE_SPACE'})).toMatchObject(
      {state: 'REJECTED', reason: 'FREE_SPACE'});
  expect(readMatch({state: 17, reason: 'REASON_UNSPECIFIED'})).toMatchObject(
      {state: '', reason: ''});
  expect(stateOf(readMatch({state: 17}))).toBe('NOT_YET');
});

test('a change says nothing of robots unless it says so', () => {
  expect(readWatchMapResponse({})).toMatchObject({hasRobots: false, run: '0'});
  expect(readWatchMapResponse({hasRobots: true})).toMatchObject({hasRobots: true, robots: []});
  const change = readWatchMapResponse({tiles: [{id: {x: -1}, version: '18446744073709551615'}],
                                removedTiles: [{component: 1, x: 2, y: -3}]});
  expect(change.tiles[0]).toMatchObject(
      {id: {component: 0, level: 0, x: -1, y: 0}, version: '18446744073709551615'});
  expect(change.removedTiles).toEqual([{component: 1, level: 0, x: 2, y: -3}]);
});

test('a robot that is localised has no session, and a place only where one is known', () => {
  const guest = {robot: 'guest', localising: {state: 'SEARCHING', scans: '7', receivedNs: '3000000'}};
  const change = readWatchMapResponse({hasRobots: true, robots: [{robot: 'alice', session: 'alice-1'}, guest]});
  expect(change.robots[0]!.localising).toBeUndefined();
  expect(change.robots[1]).toMatchObject(
      {robot: 'guest', session: '', component: undefined, tMapSensor: undefined,
       localising: {state: 'SEARCHING', scans: 7, receivedMs: 3, rejected: 0}});
  expect(readServerStatus({localising: [guest]}).localising).toEqual([change.robots[1]]);
  expect(readServerStatus({}).localising).toEqual([]);
});

test('a match may be accepted where something was found and nobody has decided', () => {
  const found = {tAB: {}, matcher: 'GUESS_SOURCE_PLACES', state: 'REJECTED'};
  expect(poseOf(readMatch({...found, matcher: 'GUESS_SOURCE_UNSPECIFIED'}))).toBeUndefined();
  expect(isUndecided(readMatch(found))).toBe(true);
  expect(isUndecided(readMatch({...found, state: 'ACCEPTED'}))).toBe(false);
  expect(isUndecided(readMatch({...found, manualDecision: {kind: 'REJECT'}}))).toBe(false);
});

function body(...parts: (string | Uint8Array)[]): ReadableStream<Uint8Array> {
  return new ReadableStream({
    start(controller) {
      for (const part of parts) {
        controller.enqueue(typeof part === 'string' ? new TextEncoder().encode(part) : part);
      }
      controller.close();
    },
  });
}

async function all(stream: ReadableStream<Uint8Array>): Promise<unknown[]> {
  const read = [];
  for await (const line of lines(stream)) read.push(line);
  return read;
}

test('lines may be cut anywhere, also within a letter, and empty ones say nothing', async () => {
  const bytes = new TextEncoder().encode('{"a":"Zoë"}\n\n{"b":1}\n');
  for (let cut = 0; cut <= bytes.length; cut++) {
    expect(await all(body(bytes.slice(0, cut), bytes.slice(cut)))).toEqual([{a: 'Zoë'}, {b: 1}]);
  }
});

test('an error at the end of a stream is one', async () => {
  const cut = all(body('{"a":1}\n{"error":{"code":"RESOURCE_EXHAUSTED","message":"full"}}\n'));
  await expect(cut).rejects.toMatchObject({code: 'RESOURCE_EXHAUSTED', message: 'full'});
  await expect(all(body('{"a":'))).rejects.toBeInstanceOf(RpcError);
});
