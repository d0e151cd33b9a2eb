// Anchors: submaps whose place is known from outside. Chosen by name or on the map, put by numbers.
import type {App} from '../app';
import type {Anchor, Submap} from '../api/messages';
import type {NewAnchor} from '../api/views';
import {asPlace} from '../robots';
import {fromHeading, headingDeg, matrix, plain, pose, withHeading} from '../scene/poses';
import type {Pointer, Tool} from '../tools/tool';
import {button, choice, fill, h, hint, number, row, section, setOptions} from './dom';
import {clock, count} from './format';

export function anchorSection(app: App): HTMLElement {
  const list = h('div', {class: 'rows'});
  const form = h('div', {});
  const submap = choice('Submap', [], '', (value) => app.submap.set(
      app.model.submaps.value.find((s) => nameOf(s) === value)));
  let shown = '';
  const showForm = () => {
    const chosen = app.submap.value;
    shown = anchorOf(app);
    fill(form, chosen?.tMapSubmap ? anchorForm(app, chosen) : undefined);
  };
  app.model.anchors.watch((anchors) => {
    fill(list, ...anchors.map((anchor) => line(app, anchor)));
    if (anchors.length === 0) list.append(hint('No submap is anchored.'));
    // The form with what is being typed stays, unless its anchor has changed.
    if (anchorOf(app) !== shown) showForm();
  });
  const options = () => setOptions(
      submap.select, [['', 'none'], ...app.model.submaps.value.filter((s) => s.tMapSubmap).map(
        (s) => [nameOf(s), nameOf(s)] as const)],
      app.submap.value ? nameOf(app.submap.value) : '');
  app.model.submaps.watch(options);
  app.submap.watch(() => {
    options();
    showForm();
  });
  return section('Submaps and anchors', submap.element, form, list);
}

// The chosen submap's anchor as text, to tell whether it has changed.
function anchorOf(app: App): string {
  const chosen = app.submap.value;
  return JSON.stringify(app.model.anchors.value.find((a) => chosen && nameOf(a) === nameOf(chosen)) ?? '');
}

function nameOf(submap: {session: string; index: number}): string {
  return `${submap.session}/${submap.index}`;
}

function line(app: App, anchor: Anchor): HTMLElement {
  const submap = app.model.submaps.value.find((s) => nameOf(s) === nameOf(anchor));
  const sigma = [anchor.sigmaXyM && `xy ±${anchor.sigmaXyM} m`, anchor.sigmaZM && `z ±${anchor.sigmaZM} m`,
                 anchor.sigmaDeg && `±${anchor.sigmaDeg}°`].filter(Boolean).join(', ');
  return row(false, () => app.submap.set(submap), h('span', {'aria-hidden': 'true'}, '⚓'), nameOf(anchor),
             h('span', {class: 'side'}, sigma), h('span', {class: 'sub'}, anchor.note));
}

function anchorForm(app: App, submap: Submap): HTMLElement {
  const known = app.model.anchors.value.find((a) => nameOf(a) === nameOf(submap));
  const at = known?.tMapSubmap ?? submap.tMapSubmap!;
  const lies = asPlace(submap.component, submap.tMapSubmap);
  const field = (label: string, title: string, value: number, step: number) => {
    const made = number(label, value, step);
    made.input.setAttribute('aria-label', title);
    return made;
  };
  const place = (['x', 'y', 'z'] as const).map(
      (axis) => field(axis, `Anchor ${axis}, metres`, at.translation[axis], 0.1));
  const heading = field('heading, °', 'Anchor heading, degrees', headingDeg(matrix(at)), 1);
  const sigmas = [
    field('± xy', 'Standard deviation of x and y, metres; 0: not known', known?.sigmaXyM ?? 0.5, 0.1),
    field('± z', 'Standard deviation of z, metres; 0: not known', known?.sigmaZM ?? 0, 0.1),
    field('± °', 'Standard deviation of angles, degrees; 0: not known', known?.sigmaDeg ?? 0, 1),
  ];
  const note = h('input', {type: 'text', maxlength: '1000', 'aria-label': 'Anchor note',
                           placeholder: 'why, or whence'});
  note.value = known?.note ?? '';
  const read = (): NewAnchor => {
    const [x = 0, y = 0, z = 0] = place.map((one) => one.get());
    const turned = withHeading(matrix(at), heading.get()).setPosition(x, y, z);
    return {
      session: submap.session, index: submap.index, tMapSubmap: pose(turned),
      sigmaXyM: sigmas[0]!.get(), sigmaZM: sigmas[1]!.get(), sigmaDeg: sigmas[2]!.get(),
      note: note.value.trim(),
    };
  };
  const pickOnMap = () => app.use(new PlaceTool(app, submap, (x, y, deg) => {
    place[0]!.set(x);
    place[1]!.set(y);
    if (deg !== undefined) heading.set(deg);
  }));
  return h('div', {class: 'card'}, h('strong', {}, nameOf(submap)),
           hint(`${clock(submap.firstStampMs)} to ${clock(submap.lastStampMs)}, ${count(submap.pointCount)} points, ` +
                `${submap.keyframeCount} keyframes`),
           h('div', {class: 'bar'},
             button('Go to', () => lies && app.goTo(lies),
                    {dead: lies ? undefined : 'This submap is in no map.'})),
           app.rights.part('PutAnchor', {},
             h('div', {class: 'grid3'}, ...place.map((one) => one.element)), heading.element,
             h('div', {class: 'grid3'}, ...sigmas.map((one) => one.element)), note,
             h('div', {class: 'bar'}, button('Place on map', pickOnMap),
               button(known ? 'Move anchor' : 'Anchor', () => void app.act('The submap is anchored.',
                 () => app.calls.putAnchor(read())), {class: 'main'}))),
           known ? app.rights.part('DeleteAnchor', {class: 'bar'},
             button('Remove', () => void app.act('The anchor is gone.',
               () => app.calls.deleteAnchor(submap.session, submap.index)), {class: 'bad'})) : undefined);
}

// Press where the submap's sensor stood, drag to where it looked.
class PlaceTool implements Tool {
  readonly name = 'place';
  readonly drags = true;
  readonly card = h('div', {class: 'tool', role: 'region', 'aria-label': 'Place on the map'});
  private from: {x: number; y: number} | undefined;

  constructor(private readonly app: App, private readonly submap: Submap,
              private readonly put: (x: number, y: number, deg?: number) => void) {
    fill(this.card, h('h2', {}, h('span', {}, `Place ${nameOf(submap)}`),
                      button('×', () => app.use(undefined), {'aria-label': 'Close', class: 'icon'})),
         hint('Press where its sensor stood and drag to where it looked ahead. The numbers in the ' +
              'panel follow; nothing is told to the server before you say so there.'));
    app.view.setMode('top');
  }

  down(at: Pointer): void {
    const place = this.floor(at);
    this.from = place;
    if (place) this.put(place.x, place.y);
  }

  drag(at: Pointer): void {
    const to = this.floor(at);
    if (!this.from || !to) return;
    const away = Math.hypot(to.x - this.from.x, to.y - this.from.y);
    const {x, y} = this.from;
    if (away < 0.3) return;
    const deg = (Math.atan2(to.y - y, to.x - x) * 180) / Math.PI;
    const marked = pose(fromHeading(x, y, this.submap.tMapSubmap!.translation.z, deg));
    this.app.marks.mark(marked);
    this.put(x, y, deg);
  }

  up(): void {
    this.from = undefined;
  }

  end(): void {
    this.app.marks.mark(undefined);
  }

  private floor(at: Pointer): {x: number; y: number} | undefined {
    const place = this.app.view.onHeight(at.x, at.y, this.submap.tMapSubmap!.translation.z);
    return place && plain(place);
  }
}
