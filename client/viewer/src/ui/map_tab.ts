// The panel's first page: what is shown of the map, and how.
import type {App} from '../app';
import {CLASSES, rampBytes} from '../scene/colours';
import type {MarkSet} from '../scene/marks';
import type {ColourBy} from '../scene/point_material';
import {recall} from '../state';
import {button, choice, fill, h, hint, section, slider, swatch, toggle} from './dom';
import {count, duration, metres, moment} from './format';

const COLOURS = [
  ['height', 'Height'], ['intensity', 'Intensity'], ['robot', 'Robot'],
  ['time', 'Time last seen'], ['age', 'Age'], ['class', 'Class'],
] as const;

const AGES = [
  ['600', 'last 10 minutes'], ['3600', 'last hour'], ['86400', 'last day'], ['604800', 'last week'],
] as const;

const SETS: [MarkSet, string][] = [
  ['robots', 'Robots'], ['trails', 'Trails'], ['submaps', 'Submaps'], ['graph', 'Match graph'],
  ['loops', 'Loop closures'], ['anchors', 'Anchors'],
];

export function mapTab(app: App): HTMLElement {
  return h('div', {}, colours(app), layers(app), ceiling(app), slice(app), points(app), about(app));
}

function colours(app: App): HTMLElement {
  const {look} = app;
  const by = choice('Colour by', COLOURS, look.colourBy.value,
                    (to) => look.setColour(to as ColourBy));
  const age = choice('Window', AGES, '3600', (to) => look.setAge(Number(to)));
  const legend = h('div', {});
  const show = () => {
    by.select.value = look.colourBy.value;
    age.element.hidden = look.colourBy.value !== 'age';
    fill(legend, ...legendOf(app));
  };
  look.colourBy.watch(show);
  look.range.watch(show);
  app.model.info.watch(show);
  return section('Colour', by.element, age.element, legend);
}

function legendOf(app: App): HTMLElement[] {
  const by = app.look.colourBy.value;
  if (by === 'robot') return robotLegend(app);
  return by === 'class' ? classLegend(app) : rampLegend(app);
}

// Classes can be hidden, also where other colours are shown afterwards.
function classLegend(app: App): HTMLElement[] {
  return CLASSES.map(([name, colour], number) => {
    const made = toggle(name, !app.look.hiddenClasses.has(number),
                        (on) => app.look.showClass(number, on));
    made.element.dataset['class'] = name;
    made.element.append(swatch(colour));
    return made.element;
  });
}

function robotLegend(app: App): HTMLElement[] {
  const robots = app.model.shownComponent()?.robots ?? [];
  return robots.map((robot) => h('div', {class: 'check'},
                                 swatch(app.model.numbers.colour(robot)), robot));
}

function rampLegend(app: App): HTMLElement[] {
  const canvas = h('canvas', {class: 'legend', width: '256', height: '1', 'aria-hidden': 'true'});
  canvas.style.position = 'static';
  const data = new ImageData(new Uint8ClampedArray(rampBytes(256)), 256, 1);
  canvas.getContext('2d')?.putImageData(data, 0, 0);
  const {min, max} = app.look.range.value;
  const now = Date.now();
  const text = {
    height: [metres(min), metres(max)],
    intensity: [String(Math.round(min)), String(Math.round(max))],
    robot: ['', ''],
    time: [moment(min, now), moment(max, now)],
    age: [`${duration(now - min)} ago, or longer`, 'now'],
    class: ['', ''],
  }[app.look.colourBy.value];
  return [canvas, h('div', {class: 'ends'}, h('span', {}, text[0]!), h('span', {}, text[1]!))];
}

function layers(app: App): HTMLElement {
  const toggles = SETS.map(([set, label]) => {
    const made = toggle(label, app.marks.on[set], (on) => (app.marks.on[set] = on, app.remark()));
    made.element.dataset['set'] = set;
    return made.element;
  });
  return section('Show', h('div', {class: 'grid2'}, ...toggles));
}

// The section about a ceiling over the map.
function ceiling(app: App): HTMLElement {
  const {region} = app;
  const on = toggle('Hide it', true, (cut) => region.showLid(!cut));
  const where = hint('');
  const element = section('Ceiling', on.element, where);
  region.state.watch(({ceilingZ, lid, slice}) => {
    element.hidden = ceilingZ === undefined;
    on.set(!lid);
    where.textContent = slice ? 'The floor slice says what is shown.' :
        `Much of the map is under one: what is above ${metres(ceilingZ ?? 0)} hides the rest.`;
  });
  return element;
}

function slice(app: App): HTMLElement {
  const {region} = app;
  const on = toggle('Only one floor', false, (to) => region.change({slice: to}));
  const from = slider('From', [-5, 20, 0.05], 0, metres, (to) => region.change({sliceZ: to}));
  const high = slider('High', [0.1, 10, 0.1], 2.5, metres, (to) => region.change({sliceM: to}));
  const step = (sign: number) => () =>
      region.change({sliceZ: region.state.value.sliceZ + sign * region.state.value.sliceM});
  const buttons = h('div', {class: 'bar'}, button('Floor down', step(-1)),
                    button('Floor up', step(1)));
  app.model.info.watch(() => {
    const bounds = app.model.shownComponent()?.bounds;
    if (!bounds) return;
    from.input.min = String(Math.floor(bounds.min.z - 1));
    from.input.max = String(Math.ceil(bounds.max.z));
    from.set(region.state.value.sliceZ);
  });
  region.state.watch((state) => {
    on.set(state.slice);
    from.set(state.sliceZ);
    high.set(state.sliceM);
    for (const part of [from.element, high.element, buttons]) part.hidden = !state.slice;
  });
  return section('Floor slice', on.element, from.element, high.element, buttons);
}

function points(app: App): HTMLElement {
  const {look} = app;
  return section(
      'Points',
      slider('Size', [1, 6, 0.5], Number(recall('point', '2')), (v) => `${v} px`,
             (v) => look.setPoint(v)).element,
      slider('Detail', [0.5, 8, 0.5], Number(recall('gap', '2.5')), (v) => `${v} px`,
             (v) => look.setGap(v)).element,
      slider('At most', [0.5, 20, 0.5], Number(recall('budget', '4')), (v) => `${v} M`,
             (v) => look.setBudget(v)).element,
      hint('Detail: how far apart points may lie on the screen before finer ones are fetched.'));
}

function about(app: App): HTMLElement {
  const text = h('div', {class: 'card'});
  const show = () => {
    const component = app.model.shownComponent();
    const info = app.model.info.value;
    if (!component || !info) return fill(text, 'Nothing is mapped yet.');
    const size = component.bounds;
    const submaps =
        app.model.submaps.value.filter((submap) => submap.component === component.component);
    fill(text, h('dl', {}, ...[
      ['points', count(component.pointCount)],
      ['submaps', count(submaps.length)],
      ['extent', size ? `${metres(size.max.x - size.min.x)} × ${metres(size.max.y - size.min.y)} × ` +
          metres(size.max.z - size.min.z) : '–'],
      ['frame of', component.referenceSession],
      ['server', app.model.status.value?.version ?? '–'],
    ].flatMap(([key, value]) => [h('dt', {}, key!), h('dd', {}, value!)])));
  };
  app.model.info.watch(show);
  app.model.submaps.watch(show);
  app.model.status.watch(show);
  return section('This map', text);
}
