// The messages that the viewer reads, as it wants them: plain numbers, no absent lists.
import {bool, list, maybe, messages, millis, name, num, obj, str, type Json, type JsonObject}
  from './json';

export interface Vec {x: number; y: number; z: number}
export interface Pose {translation: Vec; rotation: Vec & {w: number}}
export interface Box {min: Vec; max: Vec}

export function readVec(o: JsonObject): Vec {
  return {x: num(o['x']), y: num(o['y']), z: num(o['z'])};
}

// A pose without a rotation is one without turning.
export function readPose(o: JsonObject): Pose {
  const q = obj(o['rotation']);
  const rotation = {...readVec(q), w: num(q['w'])};
  if (rotation.x === 0 && rotation.y === 0 && rotation.z === 0 && rotation.w === 0) rotation.w = 1;
  return {translation: readVec(obj(o['translation'])), rotation};
}

export function writePose(pose: Pose): JsonObject {
  return {translation: {...pose.translation}, rotation: {...pose.rotation}};
}

export function readBox(o: JsonObject): Box {
  return {min: readVec(obj(o['min'])), max: readVec(obj(o['max']))};
}

export interface Component {
  component: number;
  referenceSession: string;
  sessions: string[];
  robots: string[];
  points: number;
  bounds: Box | undefined;
}

export interface MapInfo {
  revision: number;
  robots: string[];
  components: Component[];
  settled: boolean;
  storageProblem: string;
}

export function readMapInfo(o: JsonObject): MapInfo {
  return {
    revision: num(o['revision']),
    robots: list(o['robots'], str),
    components: messages(o['components'], (c) => ({
      component: num(c['component']),
      referenceSession: str(c['referenceSession']),
      sessions: list(c['sessions'], str),
      robots: list(c['robots'], str),
      points: num(c['pointCount']),
      bounds: maybe(c['bounds'], readBox),
    })),
    settled: bool(o['settled']),
    storageProblem: str(o['storageProblem']),
  };
}

export interface Submap {
  session: string;
  index: number;
  robot: string;
  firstMs: number;
  lastMs: number;
  keyframes: number;
  points: number;
  component: number | undefined;
  pose: Pose | undefined;  // T_map_submap.
}

export function readSubmap(o: JsonObject): Submap {
  return {
    session: str(o['session']),
    index: num(o['index']),
    robot: str(o['robot']),
    firstMs: millis(o['firstStampNs']),
    lastMs: millis(o['lastStampNs']),
    keyframes: num(o['keyframeCount']),
    points: num(o['pointCount']),
    component: o['component'] === undefined || o['component'] === null ? undefined :
                                                                        num(o['component']),
    pose: maybe(o['tMapSubmap'], readPose),
  };
}

export const MATCH_STATES = ['ACCEPTED', 'REJECTED', 'AMBIGUOUS', 'NOT_YET'] as const;
export type MatchState = (typeof MATCH_STATES)[number];
export type DecisionKind = 'ACCEPT' | 'REJECT' | 'SET' | '';

export interface Match {
  a: string;  // Sessions.
  b: string;
  robotA: string;
  robotB: string;
  pose: Pose | undefined;  // T_a_b of the odom frames.
  state: MatchState;
  reason: string;  // As "LOW_OVERLAP".
  detail: string;
  confidence: number;
  overlap: number;
  residualM: number;
  freeSpace: number;
  sharedM2: number;
  inTree: boolean;
  decision: DecisionKind;
  note: string;
  computedMs: number;
}

function found(match: JsonObject): boolean {
  const matcher = str(match['matcher']).replace('GUESS_SOURCE_UNSPECIFIED', '');
  return matcher !== '' || match['manualDecision'] !== undefined;
}

export function readMatch(o: JsonObject): Match {
  const decision = obj(o['manualDecision']);
  return {
    a: str(o['sessionA']),
    b: str(o['sessionB']),
    robotA: str(o['robotA']),
    robotB: str(o['robotB']),
    // A match for which nothing was found has none.
    pose: found(o) ? maybe(o['tAB'], readPose) : undefined,
    state: name(o['state'], MATCH_STATES, 'NOT_YET'),
    reason: str(o['reason']).replace(/^REASON_/, '').replace('UNSPECIFIED', ''),
    detail: str(o['detail']),
    confidence: num(o['confidence']),
    overlap: num(o['overlap']),
    residualM: num(o['residualM']),
    freeSpace: num(o['freeSpace']),
    sharedM2: num(o['sharedAreaM2']),
    inTree: bool(o['inTree']),
    decision: name(decision['kind'], ['ACCEPT', 'REJECT', 'SET'], ''),
    note: str(decision['note']),
    computedMs: millis(o['computedNs']),
  };
}

// Something was found between the two that neither a person nor the server has accepted or rejected
// for good: by hand alone is for good.
export function isUndecided(match: Match): boolean {
  return match.pose !== undefined && match.state !== 'ACCEPTED' && match.decision === '';
}

// One for both directions of a pair.
export function pairKey(a: string, b: string): string {
  return a < b ? `${a} ~ ${b}` : `${b} ~ ${a}`;
}

// Of a session that has been placed.
export interface Placement {
  component: number;
  pose: Pose;  // T_map_odom at its newest submap.
}

export interface Session {
  id: string;      // "alice-1", or "alice-1.2" of a later segment.
  opened: string;  // What the robot opened, "alice-1".
  robot: string;
  finishedMs: number;  // 0: it is open, or a later segment.
  submaps: number;
  placement: Placement | undefined;
}

export function readSession(o: JsonObject): Session {
  const placed = o['component'] !== undefined && o['component'] !== null;
  return {
    id: str(o['id']),
    opened: str(o['firstSegment']) || str(o['id']),
    robot: str(o['robot']),
    finishedMs: millis(o['finishedNs']),
    submaps: num(o['submapCount']),
    placement: placed ? {component: num(o['component']), pose: readPose(obj(o['tMapOdom']))} :
                        undefined,
  };
}

export interface Loop {
  id: string;
  session: string;
  robot: string;
  submapA: number;
  submapB: number;
  confidence: number;
  overlap: number;
  residualM: number;
  detail: string;
  rejected: boolean;
  note: string;
  edges: number;
  edgesUsed: number;
}

export function readLoop(o: JsonObject): Loop {
  return {
    id: str(o['id']) || '0',
    session: str(o['session']),
    robot: str(o['robot']),
    submapA: num(o['submapA']),
    submapB: num(o['submapB']),
    confidence: num(o['confidence']),
    overlap: num(o['overlap']),
    residualM: num(o['residualM']),
    detail: str(o['detail']),
    rejected: bool(o['rejected']),
    note: str(o['note']),
    edges: num(o['edgeCount']),
    edgesUsed: num(o['edgesUsed']),
  };
}

export interface Anchor {
  session: string;
  index: number;
  robot: string;
  pose: Pose;
  sigmaXyM: number;
  sigmaZM: number;
  sigmaDeg: number;
  note: string;
}

export function readAnchor(o: JsonObject): Anchor {
  return {
    session: str(o['session']),
    index: num(o['index']),
    robot: str(o['robot']),
    pose: readPose(obj(o['tMapSubmap'])),
    sigmaXyM: num(o['sigmaXyM']),
    sigmaZM: num(o['sigmaZM']),
    sigmaDeg: num(o['sigmaDeg']),
    note: str(o['note']),
  };
}

export function writeAnchor(anchor: Anchor): JsonObject {
  return {
    session: anchor.session,
    index: anchor.index,
    tMapSubmap: writePose(anchor.pose),
    sigmaXyM: anchor.sigmaXyM,
    sigmaZM: anchor.sigmaZM,
    sigmaDeg: anchor.sigmaDeg,
    note: anchor.note,
  };
}

export interface Revision {
  revision: number;
  ms: number;
  cause: string;
  matches: [string, string][];
  loops: string[];
  added: number;
  moved: number;
  removed: number;
  largestMoveM: number;
}

export function readRevision(o: JsonObject): Revision {
  return {
    revision: num(o['revision']),
    ms: millis(o['stampNs']),
    cause: str(o['cause']),
    matches: messages(o['matches'], (m) => [str(m['sessionA']), str(m['sessionB'])]),
    loops: list(o['loops'], str),
    added: num(o['added']),
    moved: num(o['moved']),
    removed: num(o['removed']),
    largestMoveM: num(o['largestMoveM']),
  };
}

export interface SubmapMove {
  session: string;
  index: number;
  before: Pose | undefined;
  after: Pose | undefined;
  referenceBefore: string;
  referenceAfter: string;
}

export function readMove(o: JsonObject): SubmapMove {
  return {
    session: str(o['session']),
    index: num(o['index']),
    before: maybe(o['before'], readPose),
    after: maybe(o['after'], readPose),
    referenceBefore: str(o['referenceBefore']),
    referenceAfter: str(o['referenceAfter']),
  };
}

export interface Event {
  number: number;
  ms: number;
  kind: string;
  text: string;
  who: string;
  robot: string;
}

export function readEvent(o: JsonObject): Event {
  return {
    number: num(o['number']),
    ms: millis(o['timeNs']),
    kind: str(o['kind']),
    text: str(o['text']),
    who: str(o['who']),
    robot: str(o['robot']),
  };
}

export interface SessionLoad {
  session: string;
  robot: string;
  waitingScans: number;
  processed: number;
  rejected: number;
  skipped: number;
  tracking: 'OK' | 'DEGENERATE' | 'LOST' | '';
  receivedMs: number;
  ackDelayMs: number;
  unacknowledgedMs: number;  // Since when the oldest unacknowledged scan waits; 0: none.
  submaps: number;
}

// The state of a robot that is found in the map that others made.
export interface Localising {
  state: 'SEARCHING' | 'AMBIGUOUS' | 'LOCATED' | 'UNCERTAIN' | '';  // As of its newest scan.
  sinceMs: number;
  receivedMs: number;  // When its newest scan came; 0: none has.
  scans: number;
  rejected: number;
}

export interface RobotNow {
  robot: string;                       // Empty where one that is localised gave no name.
  session: string;                     // Empty for one that is localised.
  component: number | undefined;       // Absent until it has been placed, or located.
  pose: Pose | undefined;              // T_map_sensor, of its newest scan.
  ms: number;                          // Of that scan.
  lagMs: number;
  localising: Localising | undefined;  // Of one that maps: none.
}

export function readRobot(o: JsonObject): RobotNow {
  const component = o['component'];
  return {
    robot: str(o['robot']),
    session: str(o['session']),
    component: component === undefined || component === null ? undefined : num(component),
    pose: maybe(o['tMapSensor'], readPose),
    ms: millis(o['stampNs']),
    lagMs: num(o['lagMs']),
    localising: maybe(o['localising'], (l) => ({
      state: name(l['state'], ['SEARCHING', 'AMBIGUOUS', 'LOCATED', 'UNCERTAIN'], ''),
      sinceMs: millis(l['sinceNs']),
      receivedMs: millis(l['receivedNs']),
      scans: num(l['scans']),
      rejected: num(l['rejected']),
    })),
  };
}

export interface Status {
  version: string;
  site: string;
  nowMs: number;
  revision: number;
  submaps: number;
  sessions: SessionLoad[];
  localising: RobotNow[];
  matchingIdle: boolean;
  pairs: number;
  placementWaits: boolean;
  compositionWaits: boolean;
  loading: boolean;
  storageProblem: string;
  replicaProblem: string;
  degraded: string[];
  refused: Map<string, string>;  // Methods that the caller may not call, and why.
}

export function readStatus(o: JsonObject): Status {
  const matching = obj(o['matching']);
  return {
    version: str(o['version']),
    site: str(o['site']),
    nowMs: millis(o['nowNs']),
    revision: num(o['revision']),
    submaps: num(o['submaps']),
    sessions: messages(o['sessions'], readLoad),
    localising: messages(o['localising'], readRobot),
    matchingIdle: bool(matching['idle']),
    pairs: num(matching['pairs']),
    placementWaits: bool(o['placementWaits']),
    compositionWaits: bool(o['compositionWaits']),
    loading: bool(o['mapIsLoading']),
    storageProblem: str(o['storageProblem']),
    replicaProblem: str(obj(o['replica'])['problem']),
    degraded: messages(o['degraded'], (d) => str(d['why'])),
    refused: new Map(messages(o['refused'], (r) => [str(r['method']), str(r['why'])] as const)),
  };
}

function readLoad(o: JsonObject): SessionLoad {
  const tracking = str(o['tracking']).replace(/^TRACKING_/, '');
  return {
    session: str(o['session']),
    robot: str(o['robot']),
    waitingScans: num(o['waitingScans']),
    processed: num(o['scansProcessed']),
    rejected: num(o['scansRejected']),
    skipped: num(o['scansSkipped']),
    tracking: name(tracking, ['OK', 'DEGENERATE', 'LOST'], ''),
    receivedMs: millis(o['receivedNs']),
    ackDelayMs: millis(o['ackDelayNs']),
    unacknowledgedMs: millis(o['oldestUnacknowledgedNs']),
    submaps: num(o['submaps']),
  };
}

export interface StampedPose {ms: number; pose: Pose}

export function readStamped(value: Json): StampedPose {
  const o = obj(value);
  return {ms: millis(o['stampNs']), pose: readPose(obj(o['pose']))};
}
