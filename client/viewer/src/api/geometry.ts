// Places of the API, and how they are read from its JSON.
import {num, obj, type JsonObject} from './json';

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
