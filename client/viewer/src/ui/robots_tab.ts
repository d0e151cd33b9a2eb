// The robots: who is under way, how well tracked, how far behind; whose points are shown.
import type {App} from '../app';
import type {SessionLoad} from '../api/messages';
import {vector} from '../scene/poses';
import {button, fill, h, hint, section, swatch} from './dom';
import {count, duration, plural} from './format';

const SILENT_MS = 3000;  // LiDARs scan at 5 to 20 Hz; a stream that is only late catches up sooner.

export function robotsTab(app: App): HTMLElement {
  const list = h('div', {class: 'rows'});
  const work = h('div', {});
  const show = () => {
    const robots = app.model.info.value?.robots ?? [];
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
  const shown = !app.hidden.value.has(robot);
  const box = h('input', {
    type: 'checkbox', 'aria-label': `Show ${robot}`,
    onchange: () => app.toggleRobot(robot, box.checked),
  });
  box.checked = shown;
  const component = now?.component ?? model.placements.value.find((p) => p.robot === robot)?.component;
  const elsewhere = component !== undefined && component !== model.component.value;
  const go = button('Go to', () => {
    if (elsewhere) model.component.set(component);
    if (now?.pose) app.view.lookAt(vector(now.pose.translation));
  }, {'aria-label': `Go to ${robot}`, disabled: !now?.pose && !elsewhere});
  return h('div', {class: 'row'}, h('span', {class: 'check'}, box, swatch(model.numbers.colour(robot))),
           h('strong', {}, robot), go, h('span', {class: 'sub'}, ...state(app, load, now?.lagMs ?? 0),
           elsewhere ? ` · in map ${component}` : '', component === undefined ? ' · not placed' : ''));
}

function state(app: App, load: SessionLoad | undefined, lagMs: number): (Node | string)[] {
  if (!load) return ['no open session'];
  const silent = load.receivedMs > 0 && (app.model.status.value?.nowMs ?? 0) - load.receivedMs > SILENT_MS;
  const words = silent ? ['warn', 'silent'] : {
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
