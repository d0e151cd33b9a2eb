// A box over the map: drawn from above, set by numbers, to clip to and to download.
import {Group, Vector3} from 'three';
import type {Box} from '../api/geometry';
import {isAbort, message, type Rpc} from '../api/rpc';
import {boxText, type Region} from '../region';
import {boxEdges, clear, lines} from '../scene/lines';
import {vector} from '../scene/poses';
import type {View} from '../scene/view';
import {ASKING, button, choice, die, fill, h, hint, number, toggle, type NumberField}
  from '../ui/dom';
import {metres} from '../ui/format';
import type {Pointer, Tool} from './tool';

const FORMATS = [
  ['pcd', 'PCD'], ['ply', 'PLY'], ['bt', 'OctoMap, binary (.bt)'], ['ot', 'OctoMap, full (.ot)'],
] as const;

export interface BoxContext {
  view: View;
  region: Region;
  rpc: Rpc;
  map: () => string | undefined;  // The name of the one that is shown.
  bounds: () => Box | undefined;  // The bounds of that map.
  tell: (text: string, bad?: boolean) => void;
  close: () => void;
}

export class BoxTool implements Tool {
  readonly name = 'box';
  readonly card = h('div', {class: 'tool', role: 'region', 'aria-label': 'Box'});
  drags = false;
  private readonly group = new Group();
  private from: Vector3 | undefined;
  private fields: NumberField[] = [];
  private format: string = 'pcd';
  private resolution = 0;

  constructor(private readonly context: BoxContext) {
    context.view.overlay.add(this.group);
    this.drags = !context.region.state.value.box;
    this.render();
    this.draw();
  }

  down(at: Pointer): void {
    this.from = this.onFloor(at);
  }

  drag(at: Pointer): void {
    const to = this.onFloor(at);
    const bounds = this.context.bounds();
    if (!this.from || !to || !bounds) return;
    this.set({
      min: {x: Math.min(this.from.x, to.x), y: Math.min(this.from.y, to.y), z: bounds.min.z - 0.1},
      max: {x: Math.max(this.from.x, to.x), y: Math.max(this.from.y, to.y), z: bounds.max.z + 0.1},
    });
  }

  up(): void {
    const drawn = this.from !== undefined && this.context.region.state.value.box !== undefined;
    this.from = undefined;
    if (!drawn) return;
    // One box for one press of the button: then the view can be moved again.
    this.drags = false;
    this.render();
  }

  end(): void {
    clear(this.group);
    this.group.removeFromParent();
    this.context.view.draw();
  }

  private onFloor(at: Pointer): Vector3 | undefined {
    const z = this.context.bounds()?.min.z ?? 0;
    return this.context.view.onHeight(at.x, at.y, z);
  }

  private set(box: Box | undefined): void {
    this.context.region.change({box, clip: box ? this.context.region.state.value.clip : false});
    const values = box ? [...Object.values(box.min), ...Object.values(box.max)] : [];
    this.fields.forEach((field, i) => field.set((values[i] as number) ?? 0));
    this.draw();
  }

  private draw(): void {
    clear(this.group);
    const {box} = this.context.region.state.value;
    if (box) {
      const edges = boxEdges(vector(box.min), vector(box.max));
      this.group.add(lines(edges, {colour: '#4d9bf0', px: 2, through: true}));
    }
    this.context.view.draw();
  }

  private render(): void {
    const {box, clip} = this.context.region.state.value;
    fill(this.card, h('h2', {}, h('span', {}, 'Box'),
                      button('×', this.context.close, {'aria-label': 'Close', class: 'icon'})),
         this.drags ? hint('Drag over the map from corner to corner.') : undefined,
         h('div', {class: 'bar'},
           button(box ? 'Draw anew' : 'Draw', () => (this.drags = true, this.render()),
                  {'aria-pressed': String(this.drags)}),
           button('All of it', () => this.wholeMap()),
           button('Remove', () => (this.set(undefined), this.render()),
                  {dead: box ? undefined : 'There is no box.'})),
         ...(box ? this.details(box, clip) : []), this.download());
  }

  private wholeMap(): void {
    this.drags = false;
    this.set(this.context.bounds());
    this.render();
  }

  private details(box: Box, clip: boolean): HTMLElement[] {
    const names = ['x from', 'y from', 'z from', 'x to', 'y to', 'z to'];
    const values = [...Object.values(box.min), ...Object.values(box.max)] as number[];
    this.fields = names.map((name, i) => {
      const field = number(name, values[i]!, 0.5, () => this.fromFields());
      field.input.setAttribute('aria-label', `Box ${name}, metres`);
      return field;
    });
    const size = vector(box.max).sub(vector(box.min));
    return [
      h('div', {class: 'grid3'}, ...this.fields.map((field) => field.element)),
      hint(`${metres(size.x)} × ${metres(size.y)} × ${metres(size.z)}`),
      toggle('Show only what is in it', clip,
             (on) => this.context.region.change({clip: on})).element,
    ];
  }

  private fromFields(): void {
    const [a = 0, b = 0, c = 0, d = 0, e = 0, f = 0] = this.fields.map((field) => field.get());
    this.set({
      min: {x: Math.min(a, d), y: Math.min(b, e), z: Math.min(c, f)},
      max: {x: Math.max(a, d), y: Math.max(b, e), z: Math.max(c, f)},
    });
    this.render();
  }

  private download(): HTMLElement {
    const format = choice('Format', FORMATS, this.format as 'pcd', (to) => (this.format = to));
    const resolution = number('One point per, m (0: all)', this.resolution, 0.05,
                              (to) => (this.resolution = Math.max(to, 0)));
    const {box} = this.context.region.state.value;
    const go = button(box ? 'Download the box' : 'Download the map', () => {
      die(go, ASKING);
      void this.fetch().finally(() => die(go, undefined));
    }, {class: 'main'});
    return h('section', {'aria-label': 'Download'}, format.element, resolution.element,
             h('div', {class: 'bar'}, go));
  }

  // Asks first whether there is something to have, as a link could not say why there is not.
  private async fetch(): Promise<void> {
    const {rpc, map, region, tell} = this.context;
    const {box} = region.state.value;
    const query = new URLSearchParams();
    const name = map();
    if (name) query.set('map', name);
    if (this.resolution > 0) query.set('resolution', String(this.resolution));
    if (box) query.set('box', boxText(box));
    const url = `/export/map.${this.format}?${query}`;
    const asked = new AbortController();
    try {
      await rpc.get(url, {}, asked.signal);
      asked.abort();
    } catch (error) {
      if (!isAbort(error)) tell(message(error), true);
      return;
    }
    const link = h('a', {href: rpc.url(url), download: `map.${this.format}`});
    document.body.append(link);
    link.click();
    link.remove();
    tell('The download has begun.');
  }
}
