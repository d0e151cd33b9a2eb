// The history of the map: revisions over time, what moved between two of them, and undoing one.
import type {App} from '../app';
import type {Diff} from '../api/calls';
import type {Revision} from '../api/messages';
import {pairKey, titleOf} from '../api/views';
import {Signal} from '../state';
import {button, fill, h, hint, row, section, slider} from './dom';
import {clock, metres, moment, plural} from './format';

const SHOWN = 200;  // Rows; the slider reaches all.

export function historyTab(app: App): HTMLElement {
  const diff = new Signal<Diff | undefined>(undefined);
  const chosen = new Signal<Revision | undefined>(undefined);
  diff.watch((to) => app.marks.moves(to?.moves ?? []));
  const compare = async (from: number, to: number) => {
    try {
      diff.set(await app.calls.diff(from, to));
    } catch (error) {
      diff.set(undefined);
      app.failed(error);
    }
  };
  return h('div', {}, timeline(app, diff, compare), revisions(app, chosen, diff, compare));
}

type Compare = (from: number, to: number) => Promise<void>;

function timeline(app: App, diff: Signal<Diff | undefined>, compare: Compare): HTMLElement {
  const strip = h('canvas', {class: 'strip', role: 'img', 'aria-label': 'Changes over time'});
  strip.style.position = 'static';
  const since = slider('Changes since', [0, 0, 1], 0, (v) => `rev ${v}`, () => undefined);
  const summary = h('div', {});
  // When the slider is let go, not at every step of it.
  since.input.addEventListener('change', () => void compare(since.input.valueAsNumber, 0));
  app.model.revisions.watch((revisions) => {
    const oldest = (revisions.at(-1)?.revision ?? 1) - 1;
    since.input.min = String(oldest);
    since.input.max = String(revisions[0]?.revision ?? 0);
    if (!diff.value) since.set(revisions[0]?.revision ?? 0);
    drawStrip(strip, revisions);
  });
  diff.watch((to) => {
    if (!to) return fill(summary, hint('Move the slider back to see what has changed since.'));
    const moved = to.moves.filter((m) => m.before && m.after).length;
    const came = to.moves.filter((m) => !m.before).length;
    const went = to.moves.filter((m) => !m.after).length;
    fill(summary,
         hint(`${to.to ? `Revision ${to.to}` : `Since revision ${to.from}`}: ${plural(came, 'submap')} came, ${moved} moved, ${went} went. ` +
              'On the map: orange from where they were to where they are, green what came.'),
         h('div', {class: 'bar'}, button('Clear', () => diff.set(undefined))));
  });
  return section('Timeline', strip, since.element, summary);
}

// A bar for each revision, as high as it moved the map; the newest at the right.
function drawStrip(canvas: HTMLCanvasElement, revisions: Revision[]): void {
  const [width, height] = [632, 88];
  Object.assign(canvas, {width, height});
  const pen = canvas.getContext('2d');
  if (!pen || revisions.length === 0) return;
  const shown = revisions.slice(0, 158);
  const step = Math.min(width / shown.length, 16);
  shown.forEach((revision, i) => {
    const share = Math.min(1, Math.log10(1 + 100 * revision.largestMoveM) / 3.3);
    const high = Math.max(6, share * height);
    const joins = revision.matches.length + revision.loops.length > 0;
    pen.fillStyle = revision.moved > 0 ? '#f0803c' : joins ? '#4d9bf0' : '#43b783';
    pen.fillRect(width - (i + 1) * step, height - high, Math.max(step - 2, 1), high);
  });
}

function revisions(app: App, chosen: Signal<Revision | undefined>, diff: Signal<Diff | undefined>,
                   compare: Compare): HTMLElement {
  const list = h('div', {class: 'rows'});
  const show = () => {
    const all = app.model.revisions.value;
    const current = all.find((one) => one.revision === chosen.value?.revision);
    fill(list, ...all.slice(0, SHOWN).flatMap((one) => {
      const line = row(one === current, () => {
        chosen.set(one === current ? undefined : one);
        if (one === current) diff.set(undefined);
        else void compare(one.revision - 1, one.revision);
      }, h('strong', {}, String(one.revision)), clock(one.stampMs),
         h('span', {class: 'side'}, changes(one)), h('span', {class: 'sub'}, one.cause));
      return one === current ? [line, card(app, one)] : [line];
    }));
    if (all.length === 0) list.append(hint('The map has not changed yet.'));
  };
  app.model.revisions.watch(show);
  app.model.matches.watch(show);
  app.model.loops.watch(show);
  chosen.watch(show);
  return section('Revisions', list);
}

function changes(one: Revision): string {
  const parts = [];
  if (one.added > 0) parts.push(`+${one.added}`);
  if (one.removed > 0) parts.push(`−${one.removed}`);
  if (one.moved > 0) parts.push(`${one.moved} moved`);
  return parts.join(' ');
}

// The server undoes a revision by rejecting the matches and loops that made it, as far as they hold.
function holds(app: App, one: Revision): boolean {
  const {matches, loops} = app.model;
  const accepted = new Set(matches.value.filter((m) => m.state === 'ACCEPTED').map(pairKey));
  return one.matches.some((pair) => accepted.has(pairKey(pair))) ||
      one.loops.some((id) => loops.value.some((loop) => loop.id === id && !loop.rejected));
}

function card(app: App, one: Revision): HTMLElement {
  const made = one.matches.length + one.loops.length > 0;
  return h('div', {class: 'card'}, hint(moment(one.stampMs, Date.now())),
           h('dl', {}, ...[
             ['came', String(one.added)], ['moved', String(one.moved)], ['went', String(one.removed)],
             ['farthest', metres(one.largestMoveM)],
             ...one.matches.map((pair) => ['match', titleOf(pair)]),
             ...one.loops.map((id) => ['loop closure', String(id)]),
           ].flatMap(([k, v]) => [h('dt', {}, k!), h('dd', {}, v!)])),
           holds(app, one) ?
               app.rights.part('UndoRevision', {class: 'bar'},
                               button('Undo this revision', () => void app.undo(one),
                                      {class: 'bad'})) :
               hint(made ? 'Nothing to undo: its matches and loop closures are not accepted now.' :
                           'Nothing to undo: no match or loop closure made it.'));
}
