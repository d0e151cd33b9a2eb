import {expect, test} from 'vitest';
import type {TileInfo} from '../../src/api/messages';
import {select, shown, type Eye} from '../../src/tiles/select';
import {TileTree, type Node} from '../../src/tiles/tree';

const EDGE = 20;

function leaf(x: number, y: number, version = '1', component = 0): TileInfo {
  return {
    id: {component, level: 0, x, y}, version, revision: 1, points: 1000,
    bounds: {min: {x: x * EDGE, y: y * EDGE, z: 0}, max: {x: (x + 1) * EDGE, y: (y + 1) * EDGE, z: 3}},
  };
}

function square(from: number, to: number): TileInfo[] {
  const tiles: TileInfo[] = [];
  for (let x = from; x < to; x++) for (let y = from; y < to; y++) tiles.push(leaf(x, y));
  return tiles;
}

function tree(tiles: TileInfo[]): TileTree {
  const made = new TileTree(0);
  made.update(tiles, []);
  return made;
}

function eye(x: number, y: number, z: number, sees: Eye['sees'] = () => true): Eye {
  return {pixelsPerMetre: 900, orthographic: false, position: {x, y, z}, sees};
}

const WISH = {gapPx: 2, budget: 1e9, voxelM: 0.1};

// Every point of the ground is covered once.
function covered(nodes: Node[], from: number, to: number): boolean {
  for (let x = from; x < to; x++) {
    for (let y = from; y < to; y++) {
      const over = nodes.filter(({id}) => x >> id.level === id.x && y >> id.level === id.y);
      if (over.length !== 1) return false;
    }
  }
  return true;
}

test('the pyramid ends where four tiles are left, also around the origin', () => {
  const pyramid = tree(square(-8, 8));
  expect(pyramid.levels).toBe(4);
  expect(pyramid.roots.map(({id}) => [id.x, id.y]).sort()).toEqual([[-1, -1], [-1, 0], [0, -1], [0, 0]]);
  expect(tree(square(0, 2)).levels).toBe(1);
  expect(tree([]).roots).toEqual([]);
});

test('what changes is known by all that it lies in, and by nothing else', () => {
  const pyramid = tree(square(0, 8));
  const before = new Map([...pyramid.nodes].map(([key, node]) => [key, node.change]));
  pyramid.update([leaf(5, 1, '2'), leaf(0, 0, '1')], []);
  const changed = [...pyramid.nodes.values()].filter((n) => n.change !== before.get(n.key));
  expect(changed.map((n) => n.key).sort()).toEqual(['0/0/5/1', '0/1/2/0', '0/2/1/0']);
  pyramid.update([], [{component: 0, level: 0, x: 5, y: 1}]);
  expect(pyramid.nodes.has('0/0/5/1')).toBe(false);
  expect(pyramid.nodes.get('0/2/1/0')!.change).toBeGreaterThan(before.get('0/2/1/0')! + 1);
});

test('tiles of other components are not its own', () => {
  expect(tree([leaf(0, 0, '1', 1)]).nodes.size).toBe(0);
});

test('near tiles are fine, far ones coarse, and the ground is covered once', () => {
  const pyramid = tree(square(0, 32));
  const {wanted} = select(pyramid.roots, eye(0, 0, 2), WISH);
  expect(covered(wanted, 0, 32)).toBe(true);
  const level = (x: number) => wanted.find(({id}) => x >> id.level === id.x && x >> id.level === id.y)!;
  expect(level(0).id.level).toBe(0);
  expect(level(31).id.level).toBeGreaterThan(0);
});

test('the budget holds, and the widest gaps are closed first', () => {
  const pyramid = tree(square(0, 32));
  const {wanted} = select(pyramid.roots, eye(0, 0, 2), {...WISH, gapPx: 0.01, budget: 300_000});
  expect(wanted.reduce((sum, node) => sum + node.points, 0)).toBeLessThanOrEqual(300_000);
  expect(covered(wanted, 0, 32)).toBe(true);
  expect(Math.min(...wanted.map(({id}) => id.level))).toBe(0);
});

test('what cannot be seen is not wanted', () => {
  const pyramid = tree(square(0, 8));
  const {missing} = select(pyramid.roots, eye(0, 0, 2, (box) => box.min.x < 20), WISH);
  expect(missing.length).toBeGreaterThan(0);
  expect(missing.every((node) => node.bounds.min.x < 20)).toBe(true);
});

test('coarse tiles are asked for before the fine ones that replace them', () => {
  const {missing} = select(tree(square(0, 8)).roots, eye(0, 0, 2), WISH);
  const place = new Map(missing.map((node, i) => [node.key, i]));
  for (const node of missing) {
    if (node.parent) expect(place.get(node.parent.key)).toBeLessThan(place.get(node.key)!);
  }
});

test('a tile gives way only when all that replace it are there', () => {
  const {roots, nodes} = tree(square(0, 8));
  const {refined} = select(roots, eye(80, 80, 2), {...WISH, gapPx: 0.01});
  const there = new Set(roots.map((node) => node.key));
  const now = () => shown(roots, refined, (node) => there.has(node.key), () => true);
  expect(now().map((node) => node.key).sort()).toEqual([...there].sort());
  for (const node of nodes.values()) {
    there.add(node.key);
    expect(covered(now(), 0, 8)).toBe(true);
  }
  expect(now().every(({id}) => id.level === 0)).toBe(true);
});
