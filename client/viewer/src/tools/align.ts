// One session's map laid onto another's by hand: dragged, turned, set by numbers; then told to the
// server as what holds for the pair.
import {Matrix4, Vector3} from 'three';
import type {Placement} from '../api/views';
import {fromHeading, headingDeg, matrix, pose, withHeading} from '../scene/poses';
import type {View} from '../scene/view';
import {ASKING, button, die, fill, h, hint, number, type NumberField} from '../ui/dom';
import type {Pointer, Tool} from './tool';

export interface AlignContext {
  view: View;
  title: string;
  a: Placement;  // Stays.
  b: Placement;  // Moves.
  pivot: Vector3;  // The point that b turns about, in b's map frame.
  // The pose of b's map frame in a's at first.
  start: Matrix4;
  // Shows b's map laid by this.
  lay: (T_a_b: Matrix4) => void;
  set: (T_a_b_odom: ReturnType<typeof pose>) => Promise<void>;
  close: () => void;
}

export class Align implements Tool {
  readonly name = 'align';
  readonly drags = true;
  readonly card = h('div', {class: 'tool', role: 'region', 'aria-label': 'Lay one map on another'});
  private mapFromMap: Matrix4;  // T_map_a_map_b.
  private grabbed: {at: Vector3; before: Matrix4; turning: boolean} | undefined;
  private turn = false;
  private fields: NumberField[] = [];

  constructor(private readonly context: AlignContext) {
    this.mapFromMap = context.start.clone();
    this.render();
    this.lay(this.mapFromMap);
  }

  down(at: Pointer): void {
    const place = this.onFloor(at);
    if (!place) return;
    const before = this.mapFromMap.clone();
    this.grabbed = {at: place, before, turning: this.turn || at.shift};
  }

  drag(at: Pointer): void {
    const to = this.onFloor(at);
    if (!this.grabbed || !to) return;
    const {at: from, before, turning} = this.grabbed;
    if (!turning) {
      const shift = to.sub(from);
      this.lay(new Matrix4().makeTranslation(shift.x, shift.y, 0).multiply(before));
      return;
    }
    const centre = this.context.pivot.clone().applyMatrix4(before);
    const angle = (p: Vector3) => Math.atan2(p.y - centre.y, p.x - centre.x);
    this.turnBy(((angle(to) - angle(from)) * 180) / Math.PI, before);
  }

  up(): void {
    this.grabbed = undefined;
  }

  key(code: string, shift: boolean): boolean {
    const step = shift ? 0.02 : 0.2;
    const moves: Record<string, [number, number]> = {
      ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step],
    };
    const move = moves[code];
    if (move) {
      this.lay(new Matrix4().makeTranslation(move[0], move[1], 0).multiply(this.mapFromMap));
    } else if (code === 'Comma' || code === 'Period') {
      this.turnBy((code === 'Comma' ? 1 : -1) * (shift ? 0.1 : 1), this.mapFromMap);
    } else {
      return false;
    }
    return true;
  }

  end(): void {
    this.context.view.draw();
  }

  private onFloor(at: Pointer): Vector3 | undefined {
    const z = this.context.pivot.clone().applyMatrix4(this.mapFromMap).z;
    return this.context.view.onHeight(at.x, at.y, z);
  }

  // About the pivot.
  private turnBy(deg: number, before: Matrix4): void {
    const centre = this.context.pivot.clone().applyMatrix4(before);
    this.lay(new Matrix4().makeTranslation(centre)
                 .multiply(fromHeading(0, 0, 0, deg))
                 .multiply(new Matrix4().makeTranslation(centre.clone().negate()))
                 .multiply(before));
  }

  private lay(to: Matrix4): void {
    this.mapFromMap = to;
    const at = new Vector3().setFromMatrixPosition(to);
    [at.x, at.y, at.z, headingDeg(to)].forEach((value, i) => this.fields[i]?.set(value));
    this.context.lay(to);
    this.context.view.draw();
  }

  private fromFields(): void {
    const [x = 0, y = 0, z = 0, deg = 0] = this.fields.map((field) => field.get());
    this.lay(withHeading(this.mapFromMap, deg).setPosition(x, y, z));
  }

  private render(): void {
    const {title} = this.context;
    const field = (label: string, title: string, step: number) => {
      const made = number(label, 0, step, () => this.fromFields());
      made.input.setAttribute('aria-label', title);
      return made;
    };
    this.fields = [
      field('x', 'x, metres', 0.1), field('y', 'y, metres', 0.1), field('z', 'z, metres', 0.1),
      field('heading', 'heading, degrees', 1),
    ];
    const [x, y, z, heading] = this.fields;
    const turn = button('Turn', () => {
      this.turn = !this.turn;
      turn.setAttribute('aria-pressed', String(this.turn));
    }, {'aria-pressed': 'false'});
    const done = button('Set this', () => {
      die(done, ASKING);
      void this.context.set(this.odomFromOdom()).finally(() => die(done, undefined));
    }, {class: 'main'});
    fill(this.card, h('h2', {}, h('span', {}, title),
                      button('×', this.context.close, {'aria-label': 'Close', class: 'icon'})),
         hint('Drag moves the bright map, with Shift (or Turn) it turns. Arrows and , . do so in ' +
              'steps, with Shift in small ones. The server does not refine it: lay walls on walls.'),
         h('div', {class: 'grid3'}, x!.element, y!.element, z!.element), heading!.element,
         h('div', {class: 'bar'}, turn,
           button('As it was', () => this.lay(this.context.start.clone())),
           button('Cancel', this.context.close), done));
  }

  // T_odom_a_odom_b, what a match says.
  private odomFromOdom(): ReturnType<typeof pose> {
    return odomTransform(this.context.a, this.mapFromMap, this.context.b);
  }
}

export function odomTransform(a: Placement, mapFromMap: Matrix4, b: Placement):
    ReturnType<typeof pose> {
  return pose(matrix(a.pose).invert().multiply(mapFromMap).multiply(matrix(b.pose)));
}

// The other way round: how b's map lies on a's where the odom frames lie as a match says.
export function mapTransform(a: Placement, odomFromOdom: Matrix4, b: Placement): Matrix4 {
  return matrix(a.pose).multiply(odomFromOdom).multiply(matrix(b.pose).invert());
}
