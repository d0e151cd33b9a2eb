// The page around the map: the bar above it, the panel beside it, what lies over it.
import type {App} from '../app';
import {isAbort, message} from '../api/rpc';
import {mapTitle} from '../maps';
import {isCut} from '../region';
import {recall, remember} from '../state';
import {BoxTool} from '../tools/box';
import {Measure} from '../tools/measure';
import {askToken, showHelp} from './dialogs';
import {button, fill, h, setOptions} from './dom';
import {EventsTab} from './events_tab';
import {count, duration, metres, plural} from './format';
import {graphTab} from './graph_tab';
import {historyTab} from './history_tab';
import {mapTab} from './map_tab';
import {robotsTab} from './robots_tab';

export class Shell {
  readonly tabs = ['map', 'robots', 'graph', 'history', 'events'] as const;
  private readonly events: EventsTab;
  private readonly pages = new Map<string, HTMLElement>();
  private readonly tabButtons = new Map<string, HTMLButtonElement>();
  private readonly panel = h('aside', {'aria-label': 'Panel'});
  private readonly otherPages = new BroadcastChannel('isthmus-log-out');
  private asking = false;

  constructor(private readonly app: App, private readonly root: HTMLElement,
              stage: HTMLElement) {
    this.events = new EventsTab(app);
    this.buildPanel();
    // A click with a tool in hand is the tool's, not a label's.
    app.tool.watch((tool) => app.labels.element.classList.toggle('passive', tool !== undefined));
    stage.append(app.labels.element, this.middle(), this.notice(), this.toolCard(),
                 this.cut(), app.toasts.element);
    root.append(this.header(), stage, this.panel, this.footer());
    app.onShowTab = (tab) => this.show(tab);
    this.setTheme(recall('theme', matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark'));
    if (recall('folded', '') === 'yes') this.fold();
    this.show('map');
    app.model.live.connection.watch((now) => {
      if (now.state === 'login') this.refused(now.why);
    });
    this.otherPages.onmessage = () => location.reload();
  }

  show(tab: string): void {
    for (const [name, page] of this.pages) {
      page.hidden = name !== tab;
      this.tabButtons.get(name)?.setAttribute('aria-selected', String(name === tab));
    }
    if (tab === 'events') this.events.open();
    else this.events.close();
  }

  fold(): void {
    this.panel.hidden = !this.panel.hidden;
    this.root.classList.toggle('folded', this.panel.hidden);
    remember('folded', this.panel.hidden ? 'yes' : 'no');
  }

  turnTheme(): void {
    this.setTheme(document.documentElement.dataset['theme'] === 'light' ? 'dark' : 'light');
  }

  turnView(): void {
    this.app.view.setMode(this.app.view.mode === 'top' ? 'orbit' : 'top');
  }

  measure(): void {
    const {app} = this;
    const close = () => app.use(undefined);
    if (app.tool.value?.name === 'measure') return close();
    app.use(undefined);
    app.use(new Measure(app.view, app.labels, (at) => app.pick(at), close));
  }

  box(): void {
    const {app} = this;
    const close = () => app.use(undefined);
    if (app.tool.value?.name === 'box') return close();
    app.use(undefined);
    app.view.setMode('top');
    app.use(new BoxTool({
      view: app.view, region: app.region, rpc: app.rpc,
      map: () => app.model.shownComponent()?.referenceSession,
      bounds: () => app.model.shownComponent()?.bounds,
      tell: (text, bad) => app.toasts.show(text, bad), close,
    }));
  }

  private setTheme(theme: string): void {
    document.documentElement.dataset['theme'] = theme;
    remember('theme', theme);
    const [ground, lines] = theme === 'light' ? ['#eceff2', '#c3ccd5'] : ['#14181d', '#3a4450'];
    this.app.view.setBackground(ground!, lines!);
  }

  private header(): HTMLElement {
    const {app} = this;
    const component = h('select', {
      'aria-label': 'Which map', title: 'Maps that no match joins have no known relation',
      onchange: () => app.model.component.set(Number(component.value)),
    });
    const options = () => setOptions(component, (app.model.info.value?.components ?? []).map((c) =>
      [String(c.component), mapTitle(c)]),
      String(app.model.component.value));
    app.model.info.watch(() => {
      options();
      component.hidden = (app.model.info.value?.components.length ?? 0) < 1;
    });
    app.model.component.watch(options);
    const pill = h('span', {class: 'pill', role: 'status'});
    app.model.live.connection.watch((now) => {
      pill.dataset['state'] = now.state;
      pill.textContent = {live: 'Live', connecting: 'Connecting', lost: 'Lost', login: 'No access'}[now.state];
    });
    const orbit = button('3D', () => app.view.setMode('orbit'), {title: 'Orbit (T)'});
    const top = button('Top', () => app.view.setMode('top'), {title: 'From above (T)'});
    const measure = button('Measure', () => this.measure(), {title: 'M'});
    const box = button('Box', () => this.box(), {title: 'Clip and download (B)'});
    app.view.onMove = () => {
      orbit.setAttribute('aria-pressed', String(app.view.mode === 'orbit'));
      top.setAttribute('aria-pressed', String(app.view.mode === 'top'));
    };
    app.view.onMove();
    app.tool.watch((tool) => {
      measure.setAttribute('aria-pressed', String(tool?.name === 'measure'));
      box.setAttribute('aria-pressed', String(tool?.name === 'box'));
    });
    return h('header', {}, h('h1', {}, 'Isthmus'), component, pill,
             h('span', {class: 'spread'}),
             h('span', {class: 'seg', role: 'group', 'aria-label': 'View'}, orbit, top),
             button('Show all', () => app.showAll(), {title: 'F'}), measure, box,
             button('◐', () => this.turnTheme(), {'aria-label': 'Dark or light', class: 'icon', title: 'L'}),
             button('?', showHelp, {'aria-label': 'Help', class: 'icon'}),
             button('Panel', () => this.fold(), {title: 'P', 'aria-label': 'Fold the panel'}),
             this.logoutButton());
  }

  // The button is shown only if there is a token to forget.
  private logoutButton(): HTMLElement {
    const {app} = this;
    const out = button('Log out', () => void this.logout(), {hidden: true});
    app.model.live.connection.watch(({state}) => {
      if (state !== 'live') return;
      app.calls.ownToken().then((name) => {
        out.hidden = name === '';
        out.title = `Forget the token ${name}`;
      }, (error: unknown) => app.failed(error));
    });
    return out;
  }

  private async logout(): Promise<void> {
    try {
      await this.app.rpc.logout();
    } catch (error) {
      // No script can delete the cookie, so the token is still in the browser.
      return this.app.toasts.show(`You are still logged in: ${message(error)}`, true);
    }
    this.otherPages.postMessage('');
    location.reload();
  }

  // A page without access holds nothing of the map: a new page has neither points nor names.
  private refused(why: string): void {
    if (this.app.model.info.value) location.reload();
    else void this.login(why);
  }

  private async login(why: string): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    await askToken(why, (token) => this.app.rpc.login(token));
    this.asking = false;
    this.app.model.live.start();
  }

  private buildPanel(): void {
    const {app} = this;
    const pages = {
      map: mapTab(app), robots: robotsTab(app), graph: graphTab(app), history: historyTab(app),
      events: this.events.element,
    };
    const bar = h('div', {class: 'tabs', role: 'tablist', 'aria-label': 'Pages of the panel'});
    this.tabs.forEach((name, i) => {
      const label = name.charAt(0).toUpperCase() + name.slice(1);
      const tab = button(label, () => this.show(name), {
        role: 'tab', id: `tab-${name}`, title: String(i + 1), 'aria-controls': `page-${name}`,
      });
      const page = h('div', {
        class: 'page', role: 'tabpanel', id: `page-${name}`, 'aria-labelledby': `tab-${name}`,
      }, pages[name]);
      bar.append(tab);
      this.tabButtons.set(name, tab);
      this.pages.set(name, page);
    });
    this.panel.append(bar, ...this.pages.values());
  }

  // The message in place of a map when there is none to look at.
  private middle(): HTMLElement {
    const {model} = this.app;
    const text = h('div', {});
    const element = h('div', {class: 'middle'}, text);
    const say = (title: string, ...lines: (string | HTMLElement)[]) => {
      element.hidden = false;
      fill(text, h('h2', {}, title), ...lines.map((line) =>
        typeof line === 'string' ? h('p', {}, line) : line));
    };
    const show = () => {
      const {state} = model.live.connection.value;
      const info = model.info.value;
      const points = info?.components.some((c) => c.pointCount > 0);
      element.hidden = true;
      if (points || state === 'login') return;
      if (state === 'lost') return say('The server cannot be reached', 'See the message above.');
      if (model.status.value?.mapIsLoading) {
        return say('The server composes the map', 'It was started a short time ago. Robots can ' +
            'send already; the map is shown as soon as it is there.');
      }
      if (!info) return say('Asking for the map …');
      say('No points yet', 'The map appears here as soon as a robot has driven a few metres. ' +
          'To send a recording:',
          h('p', {}, h('code', {}, 'isthmus push --robot alice --sensor vlp16 DRIVE')),
          'Not sure what a recording holds? isthmus info DRIVE says so.');
    };
    model.info.watch(show);
    model.status.watch(show);
    model.live.connection.watch(show);
    return element;
  }

  private notice(): HTMLElement {
    const {app} = this;
    const text = h('span', {});
    const retry = button('Try now', () => app.model.live.retryNow());
    const element = h('div', {class: 'notice', 'data-kind': 'bad', role: 'alert'}, text, retry);
    const show = () => {
      const now = app.model.live.connection.value;
      const trouble = app.model.status.value?.storageProblem ?? '';
      element.hidden = now.state !== 'lost' && !trouble;
      retry.hidden = now.state !== 'lost';
      if (now.state === 'lost') {
        const again = Math.max(0, now.againMs - Date.now());
        const said = `Connection lost: ${now.why} Next attempt in ${duration(again)}. ` +
            'What is shown is as it was.';
        if (text.textContent !== said) text.textContent = said;
      } else if (trouble) {
        text.textContent = `The server stores nothing at the moment: ${trouble}`;
      }
    };
    app.model.live.connection.watch(show);
    app.model.status.watch(show);
    setInterval(show, 1000);
    return element;
  }

  // Says over the map that it is shown without its ceiling.
  private cut(): HTMLElement {
    const {region} = this.app;
    const text = h('span', {});
    const element = h('div', {class: 'cut', role: 'status'}, text,
                      button('Show it', () => region.showLid(true), {'aria-label': 'Show the ceiling'}));
    region.state.watch((state) => {
      element.hidden = !isCut(state);
      text.textContent = `The ceiling is hidden, from ${metres(state.ceilingZ ?? 0)} up.`;
    });
    return element;
  }

  private toolCard(): HTMLElement {
    const place = h('div', {});
    this.app.tool.watch((tool) => fill(place, tool?.card));
    return place;
  }

  private footer(): HTMLElement {
    const {app} = this;
    const what = h('span', {class: 'spread'});
    const where = h('span', {});
    const drawn = h('span', {});
    app.drawn.watch(({points, tiles, pending}) => {
      drawn.textContent = `${count(points)} points in ${plural(tiles, 'tile')}` +
          (pending > 0 ? `, ${pending} to come` : '');
    });
    const said = () => {
      const info = app.model.info.value;
      const status = app.model.status.value;
      const revision = status?.revision ?? info?.revision;
      const site = app.rpc.site || status?.site;
      what.textContent = [site ? `site ${site}` : '', revision === undefined ? '' : `revision ${revision}`,
                          info ? plural(info.robots.length, 'robot') : '',
                          app.look.colourBy.value === 'robot' ? 'coloured by robot' :
                                                                `coloured by ${app.look.colourBy.value}`,
      ].filter(Boolean).join(' · ');
    };
    app.model.info.watch(said);
    app.model.status.watch(said);
    app.look.colourBy.watch(said);
    app.view.canvas.addEventListener('pointermove', (event) => {
      const at = app.view.onHeight(event.offsetX, event.offsetY, app.view.controls.target.z);
      where.textContent = at ? `x ${at.x.toFixed(2)}  y ${at.y.toFixed(2)}` : '';
    });
    return h('footer', {}, what, where, drawn);
  }

  // Asked while the page is looked at.
  poll(everyMs: number): void {
    const {model} = this.app;
    const ask = () => {
      const ready = model.live.connection.value.state === 'live' || !model.status.value;
      if (document.visibilityState === 'visible' && ready) {
        model.readStatus().catch((error) => isAbort(error));
      }
    };
    ask();
    setInterval(ask, everyMs);
  }
}
