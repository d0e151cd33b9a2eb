// FOR DEVELOPMENT ONLY: what mock.mjs makes up: a building of rooms, robots that drive through it.
import {createHash} from 'node:crypto';
import {pts2} from './pts2_writer.mjs';

const TILE_M = 20;
const VOXEL_M = 0.1;
const START = Math.floor(Date.now() / 1000) - 3600;
const ns = (seconds) => String(Math.round(seconds * 1e9));
const turn = (angle) => ({z: Math.sin(angle / 2), w: Math.cos(angle / 2)});
const at = (x, y, z, angle) => ({translation: {x, y, z}, rotation: turn(angle)});
const key = (id) => `${id.component}/${id.level}/${id.x}/${id.y}`;

// A building of rooms x rooms, walls with doors, floor and some columns.
function* building(rooms, room, seed) {
  const size = rooms * room;
  const random = (a, b) => Math.abs(Math.sin(a * 12.9898 + b * 78.233 + seed) * 43758.5453) % 1;
  for (let x = 0; x < size; x += 0.2) {
    for (let y = 0; y < size; y += 0.2) yield [x, y, 0.02 * random(x, y), 20 + 30 * random(y, x)];
  }
  for (let wall = 0; wall <= rooms; wall++) {
    for (let along = 0; along < size; along += 0.12) {
      const inDoor = Math.abs((along % room) - room / 2) < 1.2 && wall > 0 && wall < rooms;
      for (let z = inDoor ? 2.2 : 0; z < 3.2; z += 0.12) {
        const light = 60 + 120 * random(wall, Math.floor(along / 3));
        yield [wall * room, along, z, light];
        yield [along, wall * room, z, light];
      }
    }
  }
  for (let i = 0; i < rooms * rooms; i++) {
    const [cx, cy] = [(i % rooms + 0.25) * room, (Math.floor(i / rooms) + 0.7) * room];
    for (let angle = 0; angle < 6.28; angle += 0.2) {
      for (let z = 0; z < 2.4; z += 0.1) {
        yield [cx + 0.5 * Math.cos(angle), cy + 0.5 * Math.sin(angle), z, 200];
      }
    }
  }
}

export class World {
  constructor(empty, token) {
    this.token = token;
    this.revision = empty ? 0 : 12;
    this.watchers = new Set();
    this.tiles = new Map();
    this.decided = new Map();
    this.anchors = [];
    this.rejectedLoop = false;
    this.events = [];
    if (!empty) {
      this.fill(0, building(6, 12, 1), (x, y) => (x < 36 + 4 * Math.sin(y) ? 'alice' : 'bob'));
      this.fill(1, building(2, 12, 2), () => 'carol');
    }
    this.components = empty ? [] : [['alice', 'bob'], ['carol']];
    this.happened('SERVER_STARTED', 'the server started');
    this.components.flat().forEach((robot) => this.happened('SESSION_OPENED', `${robot}-1`, robot));
    setInterval(() => this.tick(), 500).unref();
  }

  fill(component, points, robotOf) {
    const levels = 4;
    for (const [x, y, z, intensity] of points) {
      const robot = robotOf(x, y);
      for (let level = 0; level < levels; level++) {
        const edge = TILE_M * 2 ** level;
        const voxel = VOXEL_M * 2 ** level;
        const id = {component, level, x: Math.floor(x / edge), y: Math.floor(y / edge)};
        const tile = this.tiles.get(key(id)) ?? {id, voxels: new Map()};
        this.tiles.set(key(id), tile);
        const cell = [x, y, z].map((v) => Math.floor(v / voxel)).join() + robot;
        const stamp = START + Math.floor(50 * x + 5 * y);
        if (!tile.voxels.has(cell)) tile.voxels.set(cell, {x, y, z, intensity, robot, stamp});
      }
    }
  }

  tile(component, level, x, y) {
    const tile = this.tiles.get(key({component, level, x, y}));
    if (!tile) return undefined;
    const points = [...tile.voxels.values()];
    const robots = [...new Set(points.map((p) => p.robot))].sort();
    const bytes = pts2(points, robots);
    const version = createHash('sha256').update(bytes).digest('hex').slice(0, 16);
    return {bytes, robots, version, points};
  }

  info(tile) {
    const {points, version} = this.tile(...Object.values(tile.id));
    const range = (axis) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))];
    const [[ax, bx], [ay, by], [az, bz]] = [range('x'), range('y'), range('z')];
    return {id: tile.id, version: String(BigInt(`0x${version}`)), points: String(points.length),
            bounds: {min: {x: ax, y: ay, z: az}, max: {x: bx, y: by, z: bz}}};
  }

  robotPose(robot, seconds) {
    const offset = {alice: 0, bob: 36, carol: 0}[robot] ?? 0;
    const phase = seconds / 30;
    return at(offset + 18 + 14 * Math.cos(phase), 30 + 22 * Math.sin(phase), 0.6,
              phase + Math.PI / 2);
  }

  submapsOf(robot) {
    const component = this.components.findIndex((robots) => robots.includes(robot));
    return Array.from({length: 8}, (_, index) => ({
      session: `${robot}-1`, index, robot, component, keyframeCount: 20, pointCount: '40000',
      firstStampNs: ns(START + 60 * index), lastStampNs: ns(START + 60 * index + 55),
      tMapSubmap: this.robotPose(robot, 22 * index),
    }));
  }

  submaps() {
    return this.components.flat().flatMap((robot) => this.submapsOf(robot));
  }

  matches() {
    if (this.components.length === 0) return [];
    const match = (a, b, state, reason, extra) => ({
      sessionA: `${a}-1`, sessionB: `${b}-1`, robotA: a, robotB: b, state, reason, overlap: 0.41,
      confidence: 0.99, residualM: 0.031, freeSpace: 0.01, sharedAreaM2: 310,
      tAB: at(3, 2, 0, 0.1), matcher: 'GUESS_SOURCE_PLACES', detail: `${a} and ${b}: found by places`, ...extra,
      ...(this.decided.get(`${a}-1 ~ ${b}-1`) ?? {}),
    });
    return [match('alice', 'bob', 'ACCEPTED', 'REASON_OK', {inTree: true}),
            match('alice', 'carol', 'AMBIGUOUS', 'REASON_POSSIBLE_TWIN', {confidence: 0.4}),
            match('bob', 'carol', 'NOT_YET', 'REASON_LOW_OVERLAP', {confidence: 0, overlap: -1})];
  }

  loops() {
    return this.components.length === 0 ? [] : [{
      id: '7', session: 'alice-1', robot: 'alice', submapA: 0, submapB: 6, confidence: 0.99,
      overlap: 0.6, residualM: 0.02, detail: 'alice came back after 132 s', edgeCount: 4,
      edgesUsed: 4, rejected: this.rejectedLoop,
    }];
  }

  revisions() {
    return Array.from({length: this.revision}, (_, i) => ({
      revision: String(this.revision - i), stampNs: ns(START + 300 * (this.revision - i)),
      cause: i % 3 ? `submap alice-1/${i}` : 'match alice-1 ~ bob-1 ACCEPTED',
      matches: i % 3 ? [] : [{sessionA: 'alice-1', sessionB: 'bob-1'}], added: i % 3 ? 1 : 0,
      moved: i % 3 ? 0 : 8, largestMoveM: i % 3 ? 0 : 0.4 * (i + 1),
    }));
  }

  happened(kind, text, robot = '') {
    this.events.push({number: String(this.events.length + 1), timeNs: ns(Date.now() / 1000), kind,
                      text, robot});
    for (const watcher of this.watchers) watcher.event?.();
  }

  changed(text, kind) {
    this.revision++;
    this.happened(kind, text);
    for (const watcher of this.watchers) watcher.map?.();
    return {one: {revision: String(this.revision)}};
  }

  robotsNow() {
    const now = Date.now() / 1000;
    return [...this.localised(now), ...this.components.flat().map((robot) => ({
      robot, session: `${robot}-1`, stampNs: ns(now), lagMs: robot === 'bob' ? 3500 : 40,
      component: this.components.findIndex((robots) => robots.includes(robot)),
      tMapSensor: this.robotPose(robot, now - START),
    }))];
  }

  // One that adds nothing to the map.
  localised(now) {
    if (this.components.length === 0) return [];
    return [{robot: 'dave', component: 0, stampNs: ns(now), tMapSensor: this.robotPose('dave', now),
             localising: {state: 'LOCATED', sinceNs: ns(START), receivedNs: ns(now - 0.1),
                          scans: '3600', rejected: '2'}}];
  }

  tick() {
    for (const watcher of this.watchers) watcher.robots?.();
  }

  call(method, asked) {
    const own = this[method.split('/')[1]];
    if (own) return own.call(this, asked);
    return {error: 'UNIMPLEMENTED', status: 501, message: `the mock server has no ${method}`};
  }

  GetMapInfo() {
    return {one: {
      revision: String(this.revision), robots: this.components.flat(), settled: true,
      components: this.components.map((robots, component) => ({
        component, robots, sessions: robots.map((r) => `${r}-1`), referenceSession: `${robots[0]}-1`,
        pointCount: '200000',
        bounds: component ? {min: {x: 0, y: 0, z: 0}, max: {x: 24, y: 24, z: 3.2}} :
                            {min: {x: 0, y: 0, z: 0}, max: {x: 72, y: 72, z: 3.2}},
      })),
    }};
  }

  GetStatus() {
    const now = Date.now() / 1000;
    return {one: {
      version: 'mock', site: 'default', nowNs: ns(now), revision: String(this.revision),
      submaps: String(this.submaps().length), matching: {idle: false, pairs: '1'},
      localising: this.localised(now),
      sessions: this.components.flat().map((robot) => ({
        session: `${robot}-1`, robot, receivedNs: ns(now - 0.1), scansProcessed: '5012',
        tracking: robot === 'bob' ? 'TRACKING_LOST' : 'TRACKING_OK',
        ...(robot === 'bob' ? {oldestUnacknowledgedNs: ns(now - 3.5), waitingScans: '35'} : {}),
      })),
    }};
  }

  ListSubmaps() {
    return {lines: [{revision: String(this.revision), submaps: this.submaps()}]};
  }

  GetMatchGraph() {
    return {lines: [{matches: this.matches()}]};
  }

  ListSessions() {
    const sessions = this.components.flatMap((robots, component) => robots.map((robot) => ({
      id: `${robot}-1`, robot, component, submapCount: 8, tMapOdom: at(0, 0, 0, 0),
    })));
    return {lines: [{sessions}]};
  }

  GetOwnToken() {
    return {one: {name: this.token ? 'mock' : ''}};
  }

  ListLoops() {
    return {lines: [{loops: this.loops()}]};
  }

  ListAnchors() {
    return {lines: [{anchors: this.anchors}]};
  }

  ListRevisions() {
    return {lines: [{revisions: this.revisions()}]};
  }

  DiffRevisions({fromRevision, toRevision}) {
    const moves = this.submapsOf('alice').map((s) => ({
      session: s.session, index: s.index, after: s.tMapSubmap, referenceAfter: 'alice-1',
      ...(s.index < 6 ? {referenceBefore: 'alice-1',
                         before: at(s.tMapSubmap.translation.x + 2, s.tMapSubmap.translation.y, 0.6, 0)} : {}),
    }));
    return {lines: [{fromRevision, toRevision, moves}]};
  }

  GetTrajectory({robot}) {
    const component = this.components.findIndex((robots) => robots.includes(robot));
    const poses = Array.from({length: 180}, (_, i) => (
      {stampNs: ns(START + i), pose: this.robotPose(robot, i)}));
    return {lines: [{component, poses}]};
  }

  ListEvents() {
    return {lines: [{events: this.events, upTo: String(this.events.length)}]};
  }

  WatchEvents({after}) {
    const since = (number) => this.events.slice(Number(number));
    let told = Number(after);
    return {lines: [{upTo: String(told)}], follow: (send) => this.follow({event: () => {
      send({events: since(told), upTo: String(this.events.length)});
      told = this.events.length;
    }})};
  }

  follow(watcher) {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  WatchMap() {
    const tiles = [...this.tiles.values()].filter((tile) => tile.id.level === 0);
    const robots = () => ({hasRobots: true, robots: this.robotsNow(), run: '1',
                           revision: String(this.revision)});
    return {
      lines: [{...robots(), restart: true, tileM: TILE_M, tiles: tiles.map((t) => this.info(t))}],
      follow: (send) => this.follow({robots: () => send(robots()), map: () => send({
        run: '1', revision: String(this.revision), matches: this.matches(),
      })}),
    };
  }

  DecideMatch({sessionA, sessionB, decision, note, tAB}) {
    const pair = `${sessionA} ~ ${sessionB}`;
    const state = {ACCEPT: 'ACCEPTED', SET: 'ACCEPTED', REJECT: 'REJECTED'}[decision];
    if (state) this.decided.set(pair, {state, manualDecision: {kind: decision, note}, ...(tAB && {tAB})});
    else this.decided.delete(pair);
    return this.changed(`${pair}: ${decision}`, 'MATCH_DECIDED');
  }

  DecideLoop({decision}) {
    this.rejectedLoop = decision === 'REJECT';
    return this.changed(`loop closure 7: ${decision}`, 'LOOP_DECIDED');
  }

  PutAnchor({anchor}) {
    this.DeleteAnchor(anchor);
    this.anchors.push(anchor);
    return this.changed(`anchor at ${anchor.session}/${anchor.index}`, 'ANCHOR_SET');
  }

  DeleteAnchor({session, index}) {
    this.anchors = this.anchors.filter((a) => a.session !== session || a.index !== index);
    return this.changed(`anchor at ${session}/${index} removed`, 'ANCHOR_REMOVED');
  }

  UndoRevision({revision}) {
    return this.changed(`revision ${revision} undone`, 'REVISION_UNDONE');
  }
}
