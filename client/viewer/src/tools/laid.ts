// A map laid onto the one that is shown: bright, and moved as a whole.
import {Matrix4, Vector3} from 'three';
import type {Rpc} from '../api/rpc';
import type {RobotNumbers} from '../scene/colours';
import type {View} from '../scene/view';
import {TileLayer} from '../tiles/layer';
import type {Eye, Wish} from '../tiles/select';
import type {TileTree} from '../tiles/tree';

export class LaidMap {
  layer: TileLayer | undefined;
  private tree: TileTree | undefined;
  private below: TileLayer | undefined;
  private robot = -1;  // The number of the one whose points alone move; -1: all do.

  constructor(private readonly rpc: Rpc, private readonly view: View,
              private readonly numbers: RobotNumbers) {}

  // The map that is shown.
  onto(below: TileLayer): void {
    this.below = below;
    below.look.hidden.value = this.robot;
  }

  // If it is a part of the map that is shown, `robot`'s points move, and are not shown below.
  lay(tree: TileTree, robot: string, isPart: boolean): void {
    const number = isPart ? this.numbers.of(robot) : -1;
    if (this.layer && this.tree === tree && this.robot === number) return;
    this.clear();
    this.tree = tree;
    this.robot = number;
    this.layer = new TileLayer(this.rpc, tree, this.view.uniforms, this.numbers);
    this.layer.onChange = () => this.view.draw();
    this.layer.look.tint.value.set(1, 0.85, 0.25, 0.75);
    this.layer.look.only.value = number;
    if (this.below) this.below.look.hidden.value = number;
    this.layer.group.matrixAutoUpdate = false;
    this.view.scene.add(this.layer.group);
  }

  // Takes its map frame to that of the map that is shown.
  move(to: Matrix4): void {
    this.layer?.group.matrix.copy(to);
    this.layer?.group.updateMatrixWorld(true);
    this.view.draw();
  }

  clear(): void {
    this.layer?.dispose();
    this.layer = this.tree = undefined;
    this.robot = -1;
    if (this.below) this.below.look.hidden.value = -1;
    this.view.draw();
  }

  // To be called with each frame.
  update(eye: Eye, wish: Wish): void {
    if (this.layer) this.layer.update(moveEye(eye, this.layer.group.matrix), wish);
  }
}

// As the view looks at a map that was laid somewhere: all of its tiles count as seen.
function moveEye(eye: Eye, to: Matrix4): Eye {
  const {x, y, z} = eye.position;
  const at = new Vector3(x, y, z).applyMatrix4(to.clone().invert());
  return {...eye, position: {x: at.x, y: at.y, z: at.z}, sees: () => true};
}
