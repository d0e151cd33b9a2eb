// The tab that shows how the maps hang together: matches with their reasons, loop closures,
// anchors, and what a person may say of each.
import type {App} from '../app';
import type {Loop, Match} from '../api/messages';
import {emptyMatch, isUndecided, pairKey, poseOf, stateOf, titleOf} from '../api/views';
import {asPlace} from '../robots';
import {STATE_COLOURS} from '../scene/marks';
import {anchorSection} from './anchors';
import {button, choice, die, fill, h, hint, row, section, setOptions, swatch} from './dom';
import {metres, percent, words} from './format';

export function graphTab(app: App): HTMLElement {
  return h('div', {}, matches(app), loops(app), anchorSection(app));
}

const SHOWN = [
  ['all', 'All'], ['ACCEPTED', 'Accepted'], ['open', 'Not accepted'], ['decided', 'Decided by hand'],
] as const;

function wanted(match: Match, filter: string): boolean {
  if (filter === 'open') return match.state !== 'ACCEPTED';
  if (filter === 'decided') return match.manualDecision !== undefined;
  return filter === 'all' || match.state === filter;
}

function matches(app: App): HTMLElement {
  const {model} = app;
  const list = h('div', {class: 'rows'});
  const filter = choice('Show', SHOWN, 'all', () => show());
  const show = () => {
    const chosen = app.match.value;
    const all = model.matches.value;
    const current = chosen && all.find((m) => pairKey(m) === pairKey(chosen));
    const shown = all.filter((match) => wanted(match, filter.select.value));
    const card = current && matchCard(app, current);
    fill(list, ...shown.flatMap((match) => [row(
      match === current, () => app.match.set(match === current ? undefined : match),
      swatch(STATE_COLOURS[stateOf(match)]), titleOf(match),
      h('span', {class: 'side'}, match.manualDecision ? 'by hand' : percent(match.confidence)),
      h('span', {class: 'sub'}, `${words(stateOf(match))}${match.reason && match.reason !== 'OK' ?
        `: ${words(match.reason)}` : ''}`)), match === current ? card : undefined]));
    if (shown.length === 0) list.append(hint('None.'));
    return card;
  };
  model.matches.watch(() => void show());
  app.match.watch(() => show()?.scrollIntoView({block: 'nearest'}));
  return section('Matches', filter.element, list, byHand(app));
}

function matchCard(app: App, match: Match): HTMLElement {
  const figures: [string, string][] = [
    ['overlap', percent(match.overlap)], ['ground shared', `${match.sharedAreaM2.toFixed(0)} m²`],
    ['residual', match.residualM < 0 ? '–' : metres(match.residualM)],
    ['contradicted', match.freeSpace < 0 ? '–' : percent(match.freeSpace)],
    ['carries the map', match.inTree ? 'yes' : 'no'],
  ];
  const decision = match.manualDecision;
  if (decision) {
    figures.push(['by hand', `${words(decision.kind)}${decision.note ? `: ${decision.note}` : ''}`]);
  }
  return h('div', {class: 'card'}, h('strong', {}, titleOf(match)),
           h('p', {class: 'hint'}, match.detail),
           isUndecided(match) ? hint(`On the map: ${match.sessionB}, bright, where Accept would lay it.`) :
                                undefined,
           h('dl', {}, ...figures.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)])),
           ...match.askedDrives.map((drive) => hint(
             `To tell: ${drive.robot} drives the way on its map, ${drive.lengthM.toFixed(0)} m; ` +
             `then ${percent(drive.confidence)} if it is this place.`)),
           app.rights.part('DecideMatch', {class: 'bar'},
             button('Accept', () => void app.decide(match, 'ACCEPT'), {dead: notToAccept(match)}),
             button('Reject', () => void app.decide(match, 'REJECT'),
                    {class: 'bad', dead: decision?.kind === 'REJECT' ? DECIDED : undefined}),
             button('Lay by hand', () => app.align(match)),
             decision ? button('Withdraw', () => void app.decide(match, 'WITHDRAW')) : undefined));
}

const DECIDED = 'That is what a person has decided: Withdraw takes it back.';

function notToAccept(match: Match): string | undefined {
  if (match.manualDecision?.kind === 'ACCEPT') return DECIDED;
  return poseOf(match) ? undefined : 'Nothing was found that could be accepted: lay the one on the ' +
      'other by hand.';
}

// Any two sessions, also those of which nothing was found yet.
function byHand(app: App): HTMLElement {
  const a = choice('Onto', [], '', () => undefined);
  const b = choice('Lay', [], '', () => undefined);
  const go = button('Lay by hand', () => {
    const [sa, sb] = [a.select.value, b.select.value];
    const known = app.model.matches.value.find((m) => m.sessionA === sa && m.sessionB === sb);
    const robot = (id: string) => app.model.sessions.value.find((s) => s.id === id)?.robot ?? '';
    if (sa === sb) return app.toasts.show('Choose two different sessions.', true);
    app.align(known ??
              emptyMatch({sessionA: sa, sessionB: sb, robotA: robot(sa), robotB: robot(sb)}));
  });
  app.model.sessions.watch((sessions) => {
    const options = sessions.filter((s) => s.component !== undefined).map(({id}) => [id, id] as const);
    const [first = '', second = ''] = options.map(([id]) => id);
    const keep = (value: string, otherwise: string) =>
        options.some(([id]) => id === value) ? value : otherwise;
    setOptions(a.select, options, keep(a.select.value, first));
    setOptions(b.select, options, keep(b.select.value, second || first));
    die(go, options.length < 2 ? 'There are no two sessions in maps.' : undefined);
  });
  return h('details', {}, h('summary', {}, 'Any two sessions'),
           app.rights.part('DecideMatch', {}, b.element, a.element, h('div', {class: 'bar'}, go)));
}

function loops(app: App): HTMLElement {
  const list = h('div', {class: 'rows'});
  const show = () => {
    const all = app.model.loops.value;
    const current = all.find((loop) => loop.id === app.loop.value?.id);
    const card = current && loopCard(app, current);
    fill(list, ...all.flatMap((loop) => [row(
      loop === current, () => app.loop.set(loop === current ? undefined : loop),
      h('span', {class: loop.rejected ? 'poor' : 'good', 'aria-hidden': 'true'}, '●'),
      `${loop.session}: ${loop.submapB} on ${loop.submapA}`,
      h('span', {class: 'side'}, percent(loop.confidence)),
      h('span', {class: 'sub'}, loop.rejected ? 'rejected by hand' :
                                                `${loop.edgesUsed} of ${loop.edgeCount} edges hold`)),
      loop === current ? card : undefined]));
    if (all.length === 0) list.append(hint('No robot has come back to a place yet.'));
    return card;
  };
  app.model.loops.watch(() => void show());
  app.loop.watch(() => show()?.scrollIntoView({block: 'nearest'}));
  return section('Loop closures', list);
}

function loopCard(app: App, loop: Loop): HTMLElement {
  const submap = app.model.submaps.value.find(
      (s) => s.session === loop.session && s.index === loop.submapB);
  const place = submap && asPlace(submap.component, submap.tMapSubmap);
  return h('div', {class: 'card'}, h('p', {class: 'hint'}, loop.detail),
           loop.note ? hint(`By hand: ${loop.note}`) : undefined,
           h('div', {class: 'bar'},
             button('Go to', () => place && app.goTo(place),
                    {dead: place ? undefined : `Submap ${loop.submapB} is in no map.`}),
             app.rights.part('DecideLoop', {},
               button(loop.rejected ? 'Let it count again' : 'Reject',
                      () => void app.decideLoop(loop), {class: loop.rejected ? '' : 'bad'}))));
}
