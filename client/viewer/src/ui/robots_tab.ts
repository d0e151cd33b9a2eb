// The robots: who is under way, how well tracked, how far behind; whose points are shown.
import type {App} from '../app';
import type {RobotNow, SessionLoad} from '../api/messages';
import {vector} from '../scene/poses';
import {button, fill, h, hint, section, swatch} from './dom';
import {count, duration, plural, UNNAMED} from './format';

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
  for (const signal of [app.model.info, app.model.status, app.model.robots, app.hidden]) {
    (signal as typeof app.hidden).watch(show);
  }
  return h('div', {}, section('Robots', list), section('At work', work));
}

function line(app: App, robot: string): HTMLElement {
  const {model} = app;
  const now = model.robots.value.find((one) => one.robot === robot);
  const load = model.status.value?.sessions.find((one) => one.robot === robot);
  const localised = model.status.value?.localising.filter((one) => one.robot === robot) ?? [];
  const name = robot || UNNAMED;
  const shown = !app.hidden.value.has(robot);
  const box = h('input', {
    type: 'checkbox', 'aria-label': `Show ${name}`,
    onchange: () => app.toggleRobot(robot, box.checked),
  });
  box.checked = shown;
  const component = now?.component ?? model.placements.value.find((p) => p.robot === robot)?.component;
  const elsewhere = component !== undefined && component !== model.component.value;
  const go = button('Go to', () => {
    if (elsewhere) model.component.set(component);
    if (now?.pose) app.view.lookAt(vector(now.pose.translation));
  }, {'aria-label': `Go to ${name}`, disabled: !now?.pose && !elsewhere});
  return h('div', {class: 'row'}, h('span', {class: 'check'}, box, swatch(model.numbers.colour(robot))),
           h('strong', {}, name), go, h('span', {class: 'sub'},
           ...(load || localised.length === 0 ? state(app, load, now?.lagMs ?? 0) : []),
           ...localised.flatMap((one) => localisedState(app, one)),
           elsewhere ? ` · in map ${component}` : '',
           component === undefined && localised.length === 0 ? ' · not placed' : ''));
}

function isSilent(app: App, receivedMs: number): boolean {
  return receivedMs > 0 && (app.model.status.value?.nowMs ?? 0) - receivedMs > SILENT_MS;
}

// The words for one that is found in the map that others made, and adds nothing to it.
function localisedState(app: App, {localising}: RobotNow): (Node | string)[] {
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

function state(app: App, load: SessionLoad | undefined, lagMs: number): (Node | string)[] {
  if (!load) return ['no open session'];
  const words = isSilent(app, load.receivedMs) ? ['warn', 'silent'] : {
    OK: ['good', 'tracked'], DEGENERATE: ['warn', 'partly tracked'], LOST: ['poor', 'lost'],
    '': ['dim', 'no scans yet'],
  }[load.tracking];
  const nowMs = app.model.status.value?.nowMs ?? 0;
  const parts: string[] = [load.session];
  const behind = load.unacknowledgedMs > 0 ? nowMs - load.unacknowledgedMs : lagMs;
  if (behind > 0) parts.push(`${duration(behind)} behind`);
  if (load.waitingScans > 0) parts.push(`${plural(load.waitingScans, 'scan')} waiting`);
  if (load.receivedMs > 0) parts.push(`last scan ${duration(nowMs - load.receivedMs)} ago`);
  parts.push(plural(load.processed, 'scan'));
  if (load.rejected + load.skipped > 0) parts.push(`${load.rejected + load.skipped} not used`);
  return [h('span', {class: `state ${words[0]}`}, words[1]!), ` · ${parts.join(' · ')}`];
}

function server(app: App): HTMLElement {
  const status = app.model.status.value;
  if (!status) return hint('Asking the server …');
  const rows: string[] = [];
  if (status.loading) rows.push('The map is being composed after a start.');
  if (!status.matchingIdle) rows.push(`Matching: ${plural(status.pairs, 'pair')} with new evidence.`);
  if (status.placementWaits) rows.push('Submaps are being placed.');
  if (status.compositionWaits) rows.push('The map is being composed.');
  if (rows.length === 0) rows.push(`All of ${count(status.submaps)} submaps is in the map.`);
  // Several services may be in the same trouble.
  const bad = [...new Set([...status.degraded, status.storageProblem, status.replicaProblem])]
      .filter((text) => text !== '');
  return h('div', {}, ...rows.map((text) => hint(text)),
           ...bad.map((text) => h('p', {class: 'poor', role: 'alert'}, text)));
}
