// The choice of tiles to show. A tile gives way to its children where the gap between its points
// would be too wide on the screen. The widest gaps come first, as long as all points together stay
// within a budget.
import type {Box, Vec} from '../api/geometry';
import type {Node} from './tree';

export interface Eye {
  // Pixels that a metre takes at a distance of a metre, or anywhere where `orthographic`.
  pixelsPerMetre: number;
  orthographic: boolean;
  position: Vec;
  sees: (bounds: Box) => boolean;
}

export interface Wish {
  gapPx: number;   // Wider gaps are refined.
  budget: number;  // Points.
  voxelM: number;  // Distance of points at level 0; double at each level above.
}

export interface Selection {
  wanted: Node[];          // Nodes to show once they are there.
  refined: Set<string>;    // Nodes whose children stand for them.
  missing: Node[];         // All that is wanted or stands in for it, coarse ones first.
}

export function gapPx(node: Node, eye: Eye, voxelM: number): number {
  const gap = voxelM * 2 ** node.id.level * eye.pixelsPerMetre;
  return eye.orthographic ? gap : gap / Math.max(distance(eye.position, node.bounds), 0.5);
}

export function select(roots: Node[], eye: Eye, wish: Wish): Selection {
  const refined = new Set<string>();
  const missing: Node[] = [];
  const wanted: Node[] = [];
  const open: {node: Node; gap: number}[] = [];
  let points = 0;
  const push = (node: Node) => {
    if (!eye.sees(node.bounds)) return;
    points += node.points;
    missing.push(node);
    open.push({node, gap: gapPx(node, eye, wish.voxelM)});
  };
  roots.forEach(push);
  for (;;) {
    const widest = takeWidest(open);
    if (!widest) break;
    const {node, gap} = widest;
    const grows = node.children.filter((child) => eye.sees(child.bounds))
                      .reduce((sum, child) => sum + child.points, -node.points);
    const refine = node.children.length > 0 && gap > wish.gapPx && points + grows <= wish.budget;
    if (!refine) {
      wanted.push(node);
      continue;
    }
    refined.add(node.key);
    points -= node.points;
    node.children.forEach(push);
  }
  return {wanted, refined, missing};
}

// A tile gives way to its children only when all of them that can be seen are there; where it is
// not there itself, what there is of them.
export function shown(roots: Node[], refined: Set<string>, isThere: (node: Node) => boolean,
                      sees: (bounds: Box) => boolean): Node[] {
  const resolve = (node: Node): {whole: boolean; nodes: Node[]} => {
    if (!sees(node.bounds)) return {whole: true, nodes: []};
    if (!refined.has(node.key)) {
      // Points that were nearer lately do for those that are on their way.
      if (isThere(node)) return {whole: true, nodes: [node]};
      const finer = node.children.filter(isThere);
      return {whole: false, nodes: finer};
    }
    const parts = node.children.map(resolve);
    const whole = parts.every((part) => part.whole);
    if (!whole && isThere(node)) return {whole: true, nodes: [node]};
    return {whole, nodes: parts.flatMap((part) => part.nodes)};
  };
  return roots.flatMap((root) => resolve(root).nodes);
}

function takeWidest(open: {node: Node; gap: number}[]) {
  let best = -1;
  for (let i = 0; i < open.length; i++) {
    if (best < 0 || open[i]!.gap > open[best]!.gap) best = i;
  }
  if (best < 0) return undefined;
  const taken = open[best]!;
  open[best] = open[open.length - 1]!;
  open.pop();
  return taken;
}

export function distance(from: Vec, bounds: Box): number {
  const gap = (at: number, min: number, max: number) => Math.max(min - at, at - max, 0);
  return Math.hypot(gap(from.x, bounds.min.x, bounds.max.x),
                    gap(from.y, bounds.min.y, bounds.max.y),
                    gap(from.z, bounds.min.z, bounds.max.z));
}
