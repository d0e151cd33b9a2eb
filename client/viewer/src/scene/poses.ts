// Poses of the API as matrices and back. T_target_source takes source to target.
import {Euler, Matrix4, Quaternion, Vector3} from 'three';
import type {Box, Pose, Vec} from '../api/geometry';

export function vector(v: Vec): Vector3 {
  return new Vector3(v.x, v.y, v.z);
}

export function matrix(pose: Pose): Matrix4 {
  const {x, y, z, w} = pose.rotation;
  return new Matrix4().compose(vector(pose.translation), new Quaternion(x, y, z, w).normalize(),
                               new Vector3(1, 1, 1));
}

export function pose(m: Matrix4): Pose {
  const translation = new Vector3();
  const rotation = new Quaternion();
  m.decompose(translation, rotation, new Vector3());
  const {x, y, z, w} = rotation;
  return {translation: {...plain(translation)}, rotation: {x, y, z, w}};
}

export function plain(v: Vector3): Vec {
  return {x: v.x, y: v.y, z: v.z};
}

// Heading about z, degrees.
export function headingDeg(m: Matrix4): number {
  const e = m.elements;
  return (Math.atan2(e[1]!, e[0]!) * 180) / Math.PI;
}

export function fromHeading(x: number, y: number, z: number, deg: number): Matrix4 {
  return new Matrix4().makeRotationFromEuler(new Euler(0, 0, (deg * Math.PI) / 180))
      .setPosition(x, y, z);
}

// Turned to another heading, about its own origin, roll and pitch kept.
export function withHeading(m: Matrix4, deg: number): Matrix4 {
  const turn = fromHeading(0, 0, 0, deg - headingDeg(m));
  const at = new Vector3().setFromMatrixPosition(m);
  return turn.multiply(m.clone().setPosition(0, 0, 0)).setPosition(at);
}

export function centre(box: Box): Vector3 {
  return vector(box.min).add(vector(box.max)).multiplyScalar(0.5);
}
