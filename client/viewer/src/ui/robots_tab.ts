// The robots: who is under way, how well tracked, how far behind; whose points are shown.
import type {App} from '../app';
import type {RobotPlace, Session, SessionLoad} from '../api/messages';
import {openedAs} from '../api/views';
import {newestSession, placeOf} from '../robots';
import {button, fill, h, hint, section, swatch} from './dom';
import {duration, plural, UNNAMED} from './format';

const SILENT_MS = 3000;  // LiDARs scan at 5 to 20 Hz; a stream that is only late catches up sooner.

export function robotsTab(app: App): HTMLElement {
  const list = h('div', {class: 'rows'});
  const work = h('div', {});
  const show = () => {
    const localised = app.model.status.value?.localising ?? [];
    const robots = [...new Set([...(app.model.info.value?.robots ?? []),
                                ...localised.map((one) => one.robot)])];
    fill(list, ...robots.map((robot) => line(app, robot)));
    if (robots.length === 0) list.append(hint('No robot has sent anything yet.'));
    fill(work, server(app));
  };
  const {info, sessions, status, robots, component} = app.model;
  for (const signal of [info, sessions, status, robots, component, app.hidden]) {
    (signal as typeof app.hidden).watch(show);
  }
  return h('div', {}, section('Robots', list), section('At work', work));
}

function line(app: App, robot: string): HTMLElement {
  const {model} = app;
  const session = newestSession(robot, model.sessions.value);
  const now = model.robots.value.find((one) => session && one.session === session.id);
  const load = model.status.value?.sessions.find((one) => session && one.session === openedAs(session));
  const localised = model.status.value?.localising.filter((one) => one.robot === robot) ?? [];
  const place = placeOf(robot, session, model.robots.value, model.submaps.value);
  const isElsewhere = place && place.component !== model.component.value;
  const name = robot || UNNAMED;
  const box = h('input', {
    type: 'checkbox', 'aria-label': `Show ${name}`,
    onchange: () => app.toggleRobot(robot, box.checked),
  });
  box.checked = !app.hidden.value.has(robot);
  const go = button('Go to', () => place && app.goTo(place), {
    'aria-label': `Go to ${name}`, dead: place ? undefined : notPlaced(localised.length > 0),
  });
  return h('div', {class: 'row'}, h('span', {class: 'check'}, box, swatch(model.numbers.colour(robot))),
           h('strong', {}, name), go, h('span', {class: 'sub'},
           ...(load ? state(app, load, now?.lagMs ?? 0) : []),
           ...(session && !load && localised.length === 0 ? atRest(app, session) : []),
           ...localised.flatMap((one) => localisedState(app, one)),
           isElsewhere ? ` · in map ${place.component}` : '',
           place || localised.length > 0 ? '' : ' · in no map yet'));
}

function notPlaced(isLocalised: boolean): string {
  return isLocalised ? 'It has not been found in a map yet.' :
                       'It is in no map yet: its first submap takes a few metres of driving.';
}

// The words for one that sends this server no scans; another one may still have it open.
function atRest({model}: App, session: Session): (Node | string)[] {
  const opened = openedAs(session);
  const finishedMs = model.sessions.value.find((one) => one.id === opened)?.finishedMs ?? 0;
  const nowMs = model.status.value?.nowMs ?? 0;
  const ago = finishedMs > 0 ? [`${duration(nowMs - finishedMs)} ago`] : [];
  return [h('span', {class: 'state dim'}, finishedMs > 0 ? 'finished' : 'open'),
          ` · ${[session.id, ...ago, plural(session.submapCount, 'submap')].join(' · ')}`];
}

function isSilent(app: App, receivedMs: number): boolean {
  return receivedMs > 0 && (app.model.status.value?.nowMs ?? 0) - receivedMs > SILENT_MS;
}

// The words for one that is found in the map that others made, and adds nothing to it.
function localisedState(app: App, {localising}: RobotPlace): (Node | string)[] {
  if (!localising) return [];
  const {scans, rejected, receivedMs, sinceMs} = localising;
  const words = isSilent(app, receivedMs) ? ['warn', 'silent'] : {
    LOCATED: ['good', 'located'], UNCERTAIN: ['warn', 'uncertain'],
    AMBIGUOUS: ['warn', 'ambiguous'], SEARCHING: ['poor', 'searching'], '': ['dim', 'no scans yet'],
  }[scans > 0 ? localising.state : ''];
  const nowMs = app.model.status.value?.nowMs ?? 0;
  const parts = [`localised for ${duration(nowMs - sinceMs)}`];
  if (receivedMs > 0) parts.push(`last scan ${duration(nowMs - receivedMs)} ago`);
  if (receivedMs > sinceMs) {
    parts.push(`${((1000 * scans) / (receivedMs - sinceMs)).toFixed(1)} scans/s`);
  }
  parts.push(plural(scans, 'scan'));
  if (rejected > 0) parts.push(`${rejected} not used`);
  return [h('span', {class: `state ${words[0]}`}, words[1]!), ` · ${parts.join(' · ')} `];
}

function state(app: App, load: SessionLoad, lagMs: number): (Node | string)[] {
  const words = isSilent(app, load.receivedMs) ? ['warn', 'silent'] : {
    OK: ['good', 'tracked'], DEGENERATE: ['warn', 'partly tracked'], LOST: ['poor', 'lost'],
    '': ['dim', 'no scans yet'],
  }[load.tracking];
  const nowMs = app.model.status.value?.nowMs ?? 0;
  const parts: string[] = [load.session];
  const behind = load.oldestUnacknowledgedMs > 0 ? nowMs - load.oldestUnacknowledgedMs : lagMs;
  if (behind > 0) parts.push(`${duration(behind)} behind`);
  if (load.waitingScans > 0) parts.push(`${plural(load.waitingScans, 'scan')} waiting`);
  if (load.receivedMs > 0) parts.push(`last scan ${duration(nowMs - load.receivedMs)} ago`);
  parts.push(plural(load.scansProcessed, 'scan'));
  const unused = load.scansRejected + load.scansSkipped;
  if (unused > 0) parts.push(`${unused} not used`);
  return [h('span', {class: `state ${words[0]}`}, words[1]!), ` · ${parts.join(' · ')}`];
}

function server(app: App): HTMLElement {
  const status = app.model.status.value;
  if (!status) return hint('Asking the server …');
  const rows: string[] = [];
  if (status.mapIsLoading) rows.push('The map is being composed after a start.');
  const {matching} = status;
  if (!matching?.idle) {
    rows.push(matching?.pairs ? `Matching: ${plural(matching.pairs, 'pair')} with new evidence.` :
                                'Matching is at work.');
  }
  if (status.placementWaits) rows.push('Submaps are being placed.');
  if (status.compositionWaits) rows.push('The map is being composed.');
  if (rows.length === 0) rows.push(`Nothing waits. Placed: ${plural(status.submaps, 'submap')}.`);
  // Several services may be in the same trouble.
  const bad = [...new Set([...status.degraded.map(({why}) => why), status.storageProblem,
                        status.replica?.problem ?? ''])]
      .filter((text) => text !== '');
  return h('div', {}, ...rows.map((text) => hint(text)),
           ...bad.map((text) => h('p', {class: 'poor', role: 'alert'}, text)));
}
