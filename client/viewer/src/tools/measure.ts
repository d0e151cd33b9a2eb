// Distances between points of the map that are clicked one after the other.
import {Group, Vector3} from 'three';
import {clear, lines, path} from '../scene/lines';
import type {Labels} from '../scene/labels';
import type {Picked} from '../scene/pick';
import type {View} from '../scene/view';
import {button, fill, h, hint} from '../ui/dom';
import {metres} from '../ui/format';
import type {Pointer, Tool} from './tool';

export class Measure implements Tool {
  readonly name = 'measure';
  readonly drags = false;
  readonly card = h('div', {class: 'tool', role: 'region', 'aria-label': 'Measure'});
  private readonly group = new Group();
  private points: Vector3[] = [];

  constructor(private readonly view: View, private readonly labels: Labels,
              private readonly pick: (at: Pointer) => Picked | undefined,
              private readonly close: () => void) {
    view.overlay.add(this.group);
    this.show();
  }

  click(at: Pointer): void {
    const picked = this.pick(at);
    if (picked) this.points.push(picked.at);
    this.show(!picked);
  }

  key(code: string): boolean {
    if (code !== 'Backspace') return false;
    this.points.pop();
    this.show();
    return true;
  }

  end(): void {
    clear(this.group);
    this.group.removeFromParent();
    this.labels.set('measure', []);
    this.view.draw();
  }

  private show(missed = false): void {
    clear(this.group);
    const {points} = this;
    const dead = points.length === 0 ? 'No point has been clicked on yet.' : undefined;
    if (points.length > 1) this.group.add(lines(path(points), {colour: '#f2c14e', px: 3, through: true}));
    for (const at of points) this.group.add(cross(at));
    this.labels.set('measure', points.slice(1).map((at, i) => ({
      text: metres(at.distanceTo(points[i]!)), at: at.clone().lerp(points[i]!, 0.5),
    })));
    fill(this.card, h('h2', {}, h('span', {}, 'Measure'),
                      button('×', this.close, {'aria-label': 'Close', class: 'icon'})),
         this.figures(missed),
         h('div', {class: 'bar'},
           button('Undo point', () => this.key('Backspace'), {dead}),
           button('Clear', () => (this.points = [], this.show()), {dead})));
    this.view.draw();
  }

  private figures(missed: boolean): HTMLElement {
    const {points} = this;
    if (missed) return hint('No point of the map there: click on one.');
    if (points.length === 0) return hint('Click on points of the map.');
    const last = points.at(-1)!;
    const before = points.at(-2);
    const place = `${last.x.toFixed(2)}, ${last.y.toFixed(2)}, ${last.z.toFixed(2)}`;
    const rows: [string, string][] = [['point', place]];
    if (before) {
      const step = last.clone().sub(before);
      rows.push(['distance', metres(step.length())], ['level', metres(Math.hypot(step.x, step.y))],
                ['height', metres(step.z)]);
      const sum = points.slice(1).reduce((all, at, i) => all + at.distanceTo(points[i]!), 0);
      if (points.length > 2) rows.push(['in all', metres(sum)]);
    }
    return h('div', {class: 'card'}, h('dl', {}, ...rows.flatMap(
        ([key, value]) => [h('dt', {}, key), h('dd', {}, value)])));
  }
}

export function cross(at: Vector3): ReturnType<typeof lines> {
  const ends = [[0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]].flatMap(([x = 0, y = 0, z = 0]) => {
    const arm = new Vector3(x, y, z);
    return [at.clone().sub(arm), at.clone().add(arm)];
  });
  return lines(ends, {colour: '#f2c14e', px: 3, through: true});
}
