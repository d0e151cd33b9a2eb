// Isthmus in the browser: the merged map, live, and what a person decides about it.
import {App} from './app';
import {Rpc} from './api/rpc';
import {h} from './ui/dom';
import {watchPresses} from './press';
import {listen} from './ui/input';
import {Shell} from './ui/shell';
import './ui/style.css';

const STATUS_EVERY_MS = 2000;

function start(root: HTMLElement): void {
  const canvas = h('canvas', {tabindex: '0', role: 'application', 'aria-label': 'Map'});
  const stage = h('main', {}, canvas);
  root.append(stage);
  const site = new URLSearchParams(location.search).get('site') ?? '';
  let app: App;
  try {
    app = new App(new Rpc(site), canvas);
  } catch {
    root.replaceChildren(h('div', {class: 'middle'}, h('div', {}, h('h2', {}, 'No WebGL here'),
      h('p', {}, 'The map is drawn by WebGL 2. Switch on hardware acceleration in the settings of ' +
        'this browser, or use a newer one.'))));
    return;
  }
  watchPresses(window);
  const shell = new Shell(app, root, stage);
  listen(app, shell);
  shell.poll(STATUS_EVERY_MS);
  app.model.live.start();
  // For the browser test, and for whoever looks into the page by its console.
  Object.assign(window, {isthmus: app});
}

start(document.getElementById('app')!);
