// Lines as wide as is said in pixels, whatever the distance.
import type {Vector3} from 'three';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';

export interface Stroke {
  colour: string;
  px?: number;
  dashM?: number;   // Dashes of this length; absent: none.
  through?: boolean;  // Seen through the points.
  opacity?: number;
}

// `ends`: two points for each piece.
export function lines(ends: Vector3[], stroke: Stroke): LineSegments2 {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(ends.flatMap((at) => [at.x, at.y, at.z]));
  const material = new LineMaterial({
    color: stroke.colour,
    linewidth: stroke.px ?? 2,
    dashed: stroke.dashM !== undefined,
    dashSize: stroke.dashM ?? 1,
    gapSize: stroke.dashM ?? 1,
    depthTest: !stroke.through,
    transparent: stroke.opacity !== undefined || !!stroke.through,
    opacity: stroke.opacity ?? 1,
  });
  const object = new LineSegments2(geometry, material);
  if (stroke.dashM !== undefined) object.computeLineDistances();
  if (stroke.through) object.renderOrder = 10;
  object.frustumCulled = false;
  return object;
}

// Pairs of ends for a line through all of them.
export function path(points: Vector3[]): Vector3[] {
  return points.slice(1).flatMap((at, i) => [points[i]!, at]);
}

export function boxEdges(min: Vector3, max: Vector3): Vector3[] {
  const corner = (i: number) => min.clone().set(
      i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
  const edges: Vector3[] = [];
  for (let i = 0; i < 8; i++) {
    for (const bit of [1, 2, 4]) if (!(i & bit)) edges.push(corner(i), corner(i | bit));
  }
  return edges;
}

// Takes all of a group out and gives its memory back.
export function clear(group: {children: unknown[]; remove: (child: never) => unknown}): void {
  for (const child of [...group.children]) {
    const drawn = child as {geometry?: {dispose(): void}; material?: {dispose(): void};
                            children: unknown[]; remove: (child: never) => unknown};
    if (drawn.children.length > 0) clear(drawn);
    drawn.geometry?.dispose();
    drawn.material?.dispose();
    group.remove(child as never);
  }
}
