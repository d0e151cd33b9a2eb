// What MapService.WatchMap says: tiles, and what changes about the map.
import {bool, maybe, messages, num, obj, str, type JsonObject} from './json';
import {readBox, readMatch, readPose, readRobot, type Box, type Match, type Pose, type RobotNow}
  from './messages';

// Tile (x, y) of level L covers [x, x + 1) * tile_m * 2^L, likewise y.
export interface TileId {component: number; level: number; x: number; y: number}

export interface TileInfo {
  id: TileId;
  version: string;  // Of its content; the same content has the same.
  points: number;   // From level 1 on an upper bound.
  bounds: Box;
}

export interface SubmapPlace {
  session: string;
  index: number;
  robot: string;
  component: number | undefined;  // Absent for one that has left the map.
  pose: Pose | undefined;
}

// One response of a watch; without `more` the step that it belongs to is whole.
export interface MapChange {
  revision: number;
  run: string;
  restart: boolean;  // What was known before is to be forgotten.
  more: boolean;
  tiles: TileInfo[];
  removedTiles: TileId[];
  submaps: SubmapPlace[];
  matches: Match[];
  removedMatches: number;
  robots: RobotNow[] | undefined;  // All that are under way; undefined where it says nothing.
}

export function tileKey(id: TileId): string {
  return `${id.component}/${id.level}/${id.x}/${id.y}`;
}

export function readTileId(o: JsonObject): TileId {
  return {
    component: num(o['component']),
    level: num(o['level']),
    x: num(o['x']),
    y: num(o['y']),
  };
}

export function readTileInfo(o: JsonObject): TileInfo {
  return {
    id: readTileId(obj(o['id'])),
    version: str(o['version']),
    points: num(o['points']),
    bounds: readBox(obj(o['bounds'])),
  };
}

function component(o: JsonObject): number | undefined {
  const value = o['component'];
  return value === undefined || value === null ? undefined : num(value);
}

export function readMapChange(o: JsonObject): MapChange {
  return {
    revision: num(o['revision']),
    run: str(o['run']) || '0',
    restart: bool(o['restart']),
    more: bool(o['more']),
    tiles: messages(o['tiles'], readTileInfo),
    removedTiles: messages(o['removedTiles'], readTileId),
    submaps: messages(o['submaps'], readPlace),
    matches: messages(o['matches'], readMatch),
    removedMatches: messages(o['removedMatches'], () => 1).length,
    robots: bool(o['hasRobots']) ? messages(o['robots'], readRobot) : undefined,
  };
}

function readPlace(o: JsonObject): SubmapPlace {
  return {
    session: str(o['session']),
    index: num(o['index']),
    robot: str(o['robot']),
    component: component(o),
    pose: maybe(o['tMapSubmap'], readPose),
  };
}
