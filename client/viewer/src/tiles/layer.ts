// The points of one component as they are on the screen: keeps tiles that are or were lately shown,
// fetches what the view lacks, and lays them into the scene.
import {Box3, BufferAttribute, BufferGeometry, Group, Matrix4, Points as ThreePoints, Sphere,
        Vector3, Vector4} from 'three';
import type {Rpc, RpcError} from '../api/rpc';
import type {RobotNumbers} from '../scene/colours';
import {makePointMaterial, type Uniforms} from '../scene/point_material';
import {TileLoader, type Tile, type Want} from './loader';
import type {Points} from './pts2';
import {select, shown, type Eye, type Wish} from './select';
import type {Node, TileTree} from './tree';

// Tiles that are not shown stay in memory up to as many points again as the budget.
const SPARE = 1;

interface Kept {
  change: number;
  etag: string;
  points: Points;
  object: ThreePoints;
  used: number;  // The frame in which it was shown last.
}

export interface LayerLook {
  only: number;   // A robot's number; -1: all.
  hidden: number; // A robot's number; -1: none.
  tint: Vector4;  // w: how much of it.
}

export class TileLayer {
  readonly group = new Group();
  readonly look = {
    only: {value: -1},
    hidden: {value: -1},
    tint: {value: new Vector4(1, 1, 1, 0)},
  };
  shownPoints = 0;
  shownTiles = 0;
  onChange: () => void = () => undefined;
  onError: (error: RpcError) => void = () => undefined;
  private readonly kept = new Map<string, Kept>();
  private readonly gone = new Map<string, number>();
  private readonly loader: TileLoader;
  private frame = 0;

  constructor(rpc: Rpc, private readonly tree: TileTree, private readonly shared: Uniforms,
              private readonly robots: RobotNumbers) {
    this.loader = new TileLoader(rpc, (want, tile) => this.arrived(want, tile));
    this.loader.onError = (error) => this.onError(error);
    this.loader.onIdle = () => this.onChange();
  }

  get pending(): number {
    return this.loader.pending;
  }

  // Shows what is there for `eye` and fetches the rest. To be called when either may have changed.
  update(eye: Eye, wish: Wish): void {
    this.frame++;
    const chosen = select(this.tree.roots, eye, wish);
    const isThere = (node: Node) => this.kept.has(node.key) || this.gone.has(node.key);
    const nodes = shown(this.tree.roots, chosen.refined, isThere, eye.sees);
    this.show(nodes, wish.voxelM);
    this.loader.want(chosen.missing.filter((node) => this.isStale(node)).map((node) => ({
      key: node.key,
      id: node.id,
      change: node.change,
      etag: this.kept.get(node.key)?.etag ?? '',
    })));
    this.forget(wish.budget * (1 + SPARE));
  }

  // After a lost connection: what failed is asked for at once.
  refresh(): void {
    this.gone.clear();
  }

  dispose(): void {
    this.loader.stop();
    for (const key of [...this.kept.keys()]) this.drop(key);
    this.group.removeFromParent();
  }

  *visible(): Generator<{points: Points; bounds: Box3; matrix: Matrix4; robots: Uint8Array}> {
    for (const kept of this.kept.values()) {
      if (!kept.object.visible) continue;
      const bounds = kept.object.geometry.boundingBox!.clone().applyMatrix4(
          kept.object.matrixWorld);
      const matrix = kept.object.matrixWorld;
      yield {points: kept.points, bounds, matrix, robots: kept.points.robots};
    }
  }

  // x, y, z, map frame, of at most about so many of the points that are shown, spread over all.
  sample(most: number): Float32Array {
    const step = Math.max(1, Math.ceil(this.shownPoints / most));
    const sampled: number[] = [];
    for (const {points: {count, origin, scale, positions}} of this.visible()) {
      for (let i = 0; i < 3 * count; i += 3 * step) {
        for (let axis = 0; axis < 3; axis++) {
          sampled.push(origin[axis]! + scale[axis]! * positions[i + axis]!);
        }
      }
    }
    return Float32Array.from(sampled);
  }

  private isStale(node: Node): boolean {
    const change = this.kept.get(node.key)?.change ?? this.gone.get(node.key);
    return change === undefined || change < node.change;
  }

  private show(nodes: Node[], voxelM: number): void {
    this.shownPoints = this.shownTiles = 0;
    const keys = new Set(nodes.map((node) => node.key));
    for (const [key, kept] of this.kept) kept.object.visible = keys.has(key);
    for (const node of nodes) {
      const kept = this.kept.get(node.key);
      if (!kept) continue;
      kept.used = this.frame;
      this.shownPoints += kept.points.count;
      this.shownTiles++;
      const uniforms = kept.object.material as ReturnType<typeof makePointMaterial>;
      uniforms.uniforms['gapM']!.value = voxelM * 2 ** node.id.level;
    }
  }

  private arrived(want: Want, tile: Tile | null | undefined): void {
    const kept = this.kept.get(want.key);
    if (tile === undefined) {
      this.drop(want.key);
      this.gone.set(want.key, want.change);
    } else if (tile === null) {
      if (kept) kept.change = want.change;
    } else {
      this.drop(want.key);
      this.gone.delete(want.key);
      this.keep(want, tile);
    }
    this.onChange();
  }

  private keep(want: Want, tile: Tile): void {
    const {points} = tile;
    const numbers = tile.robots.map((robot) => this.robots.of(robot));
    for (let i = 0; i < points.count; i++) {
      points.robots[i] = numbers[points.robots[i]!] ?? 255;
    }
    const object = new ThreePoints(geometryOf(points));
    object.matrixAutoUpdate = false;
    object.matrix.makeTranslation(...points.origin).scale(new Vector3(...points.scale));
    object.frustumCulled = false;  // Chosen by the view already.
    const mapFromTile = {value: new Matrix4()};
    object.material = makePointMaterial(this.shared, {
      gapM: {value: 0.1},
      mapFromTile,
      only: this.look.only,
      hidden: this.look.hidden,
      tint: this.look.tint,
    });
    object.onBeforeRender = () => mapFromTile.value.copy(object.matrixWorld);
    object.visible = false;
    this.group.add(object);
    const {change} = want;
    this.kept.set(want.key, {change, etag: tile.etag, points, object, used: this.frame});
  }

  private forget(limit: number): void {
    let points = 0;
    for (const [key, kept] of this.kept) {
      points += kept.points.count;
      if (!this.tree.nodes.has(key)) this.drop(key);
    }
    if (points <= limit) return;
    const oldest = [...this.kept].sort(([, a], [, b]) => a.used - b.used);
    for (const [key, kept] of oldest) {
      if (points <= limit || kept.used === this.frame) return;
      points -= kept.points.count;
      this.drop(key);
    }
  }

  private drop(key: string): void {
    const kept = this.kept.get(key);
    if (!kept) return;
    kept.object.geometry.dispose();
    (kept.object.material as ReturnType<typeof makePointMaterial>).dispose();
    this.group.remove(kept.object);
    this.kept.delete(key);
  }
}

function geometryOf(points: Points): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('stored', new BufferAttribute(points.positions, 3));
  geometry.setAttribute('position', geometry.getAttribute('stored'));
  geometry.setAttribute('intensity', integers(points.intensities));
  geometry.setAttribute('robot', integers(points.robots));
  geometry.setAttribute('stamp', integers(points.stamps));
  geometry.setAttribute('label', integers(points.classes));
  geometry.boundingBox = new Box3(new Vector3(0, 0, 0), new Vector3(65535, 65535, 65535));
  geometry.boundingSphere = new Sphere(new Vector3(32768, 32768, 32768), 60000);
  return geometry;
}

function integers(values: Uint8Array | Uint32Array): BufferAttribute {
  const attribute = new BufferAttribute(values, 1);
  attribute.gpuType = 1013;  // IntType: kept as integers in the shader.
  return attribute;
}
