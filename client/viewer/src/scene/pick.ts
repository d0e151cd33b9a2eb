// The point of the map under the pointer: the one in front of those near enough on the screen.
import {Matrix4, Vector3} from 'three';
import type {TileLayer} from '../tiles/layer';
import type {View} from './view';

const NEAR_PX = 9;

export interface Picked {
  at: Vector3;  // Map frame.
  robot: number;
  intensity: number;
  stamp: number;
}

export function pick(view: View, layers: TileLayer[], x: number, y: number): Picked | undefined {
  const ray = view.ray(x, y);
  const {width, height} = view.size();
  const clip = view.uniforms;
  const hidden = clip.robots.value.image.data as Uint8Array;
  const hiddenKinds = clip.classes.value.image.data as Uint8Array;
  const at = new Vector3();
  let best: Picked | undefined;
  let bestDepth = Infinity;
  for (const layer of layers) {
    for (const tile of layer.visible()) {
      // A ray that passes the tile at some distance may still pass close to one of its points.
      if (!ray.intersectsBox(tile.bounds.expandByScalar(0.5))) continue;
      const toScreen = new Matrix4().multiplyMatrices(view.camera.projectionMatrix,
          view.camera.matrixWorldInverse).multiply(tile.matrix);
      const e = toScreen.elements;
      const p = tile.points.positions;
      for (let i = 0; i < tile.points.count; i++) {
        const [px, py, pz] = [p[3 * i]!, p[3 * i + 1]!, p[3 * i + 2]!];
        const w = e[3]! * px + e[7]! * py + e[11]! * pz + e[15]!;
        if (w <= 0) continue;
        const sx = ((e[0]! * px + e[4]! * py + e[8]! * pz + e[12]!) / w + 1) * 0.5 * width - x;
        const sy = (1 - (e[1]! * px + e[5]! * py + e[9]! * pz + e[13]!) / w) * 0.5 * height - y;
        const off = sx * sx + sy * sy;
        if (off > NEAR_PX * NEAR_PX) continue;
        const z = (e[2]! * px + e[6]! * py + e[10]! * pz + e[14]!) / w;
        // In front counts, and so does being close to the pointer.
        const depth = z + off * 1e-7;
        if (depth >= bestDepth || hidden[4 * tile.robots[i]! + 3] === 0) continue;
        if (hiddenKinds[4 * tile.points.classes[i]! + 3] === 0) continue;
        at.set(px, py, pz).applyMatrix4(tile.matrix);
        if (clip.clipOn.value && (at.x < clip.clipMin.value.x || at.x > clip.clipMax.value.x ||
            at.y < clip.clipMin.value.y || at.y > clip.clipMax.value.y ||
            at.z < clip.clipMin.value.z || at.z > clip.clipMax.value.z)) {
          continue;
        }
        bestDepth = depth;
        best = {
          at: at.clone(), robot: tile.robots[i]!, intensity: tile.points.intensities[i]!,
          stamp: tile.points.stamps[i]!,
        };
      }
    }
  }
  return best;
}
