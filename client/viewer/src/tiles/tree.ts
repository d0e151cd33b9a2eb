// The pyramid of one component's tiles, built up from level 0: the server tells of those alone, and
// a tile of a higher level is there where one of level 0 lies in it.
import type {Box} from '../api/geometry';
import type {TileId, TileInfo} from '../api/messages';
import {tileKey} from '../api/views';

export interface Node {
  id: TileId;
  key: string;
  children: Node[];
  parent: Node | undefined;
  bounds: Box;
  points: number;  // An upper bound from level 1 on.
  change: number;  // Grows when something in it does.
}

export class TileTree {
  readonly nodes = new Map<string, Node>();
  roots: Node[] = [];
  levels = 1;
  private changes = 0;

  constructor(readonly component: number) {}

  // Level 0 as it is now. What did not change keeps its `change`.
  update(changed: Iterable<TileInfo>, removed: Iterable<TileId>): void {
    this.changes++;
    const touched = new Set<string>();
    for (const info of changed) this.put(info, touched);
    for (const id of removed) this.remove(id, touched);
    this.build(touched);
  }

  // True if `sees` holds for all of level 0.
  isSeenWhole(sees: (bounds: Box) => boolean): boolean {
    return [...this.leaves.values()].every((leaf) => sees(leaf.bounds));
  }

  private readonly leaves = new Map<string, TileInfo>();

  private put(info: TileInfo, touched: Set<string>): void {
    if (info.id.component !== this.component || info.id.level !== 0) return;
    const key = tileKey(info.id);
    const before = this.leaves.get(key);
    this.leaves.set(key, info);
    if (before?.version !== info.version) touched.add(key);
  }

  private remove(id: TileId, touched: Set<string>): void {
    if (this.leaves.delete(tileKey(id))) touched.add(tileKey(id));
  }

  private build(touched: Set<string>): void {
    const before = new Map(this.nodes);
    this.nodes.clear();
    let level: Node[] = [...this.leaves.values()].map(
        (info) => this.node(info.id, [], info.bounds, info.points, touched, before));
    this.levels = 1;
    // The last level is the first with four tiles at most, as on the server.
    while (level.length > 4) {
      level = this.above(level, touched, before);
      this.levels++;
    }
    this.roots = level;
    // A tile whose parts are gone has no node any more, but what it lay in has changed.
    for (const key of touched) if (!this.nodes.has(key)) this.touchAbove(key);
  }

  private above(level: Node[], touched: Set<string>, before: Map<string, Node>): Node[] {
    const groups = new Map<string, {id: TileId; children: Node[]}>();
    for (const child of level) {
      const id = parentOf(child.id);
      const group = groups.get(tileKey(id)) ?? {id, children: []};
      group.children.push(child);
      groups.set(tileKey(id), group);
    }
    return [...groups.values()].map(({id, children}) => {
      const bounds = children.map((child) => child.bounds).reduce(union);
      // One voxel of this level holds up to four of the one below, on surfaces; two are usual.
      const points = Math.ceil(children.reduce((sum, child) => sum + child.points, 0) / 2);
      const node = this.node(id, children, bounds, points, touched, before);
      for (const child of children) {
        child.parent = node;
        node.change = Math.max(node.change, child.change);
      }
      return node;
    });
  }

  private node(id: TileId, children: Node[], bounds: Box, points: number, touched: Set<string>,
               before: Map<string, Node>): Node {
    const key = tileKey(id);
    const known = before.get(key)?.change ?? this.changes;
    const change = touched.has(key) ? this.changes : known;
    const node: Node = {id, key, children, parent: undefined, bounds, points, change};
    this.nodes.set(key, node);
    return node;
  }

  private touchAbove(key: string): void {
    const [component = 0, level = 0, x = 0, y = 0] = key.split('/').map(Number);
    let id: TileId = {component, level, x, y};
    while (id.level < this.levels) {
      id = parentOf(id);
      const node = this.nodes.get(tileKey(id));
      if (node) node.change = this.changes;
    }
  }
}

export function parentOf(id: TileId): TileId {
  return {component: id.component, level: id.level + 1, x: id.x >> 1, y: id.y >> 1};
}

function union(a: Box, b: Box): Box {
  return {
    min: {
      x: Math.min(a.min.x, b.min.x),
      y: Math.min(a.min.y, b.min.y),
      z: Math.min(a.min.z, b.min.z),
    },
    max: {
      x: Math.max(a.max.x, b.max.x),
      y: Math.max(a.max.y, b.max.y),
      z: Math.max(a.max.z, b.max.z),
    },
  };
}
