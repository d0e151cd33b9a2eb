// The event log, followed while its page is open.
import type {App} from '../app';
import type {Event} from '../api/messages';
import {isAbort, message, RpcError} from '../api/rpc';
import {Backoff, sleep} from '../retry';
import {choice, fill, h, hint, section, setOptions} from './dom';
import {moment, words} from './format';

const FIRST = 300;
const KEPT = 2000;

export class EventsTab {
  readonly element: HTMLElement;
  private readonly list = h('div', {class: 'rows', role: 'log', 'aria-label': 'Events'});
  private readonly kind = choice('Kind', [['', 'All kinds']], '', () => this.show());
  private readonly robot = choice('Robot', [['', 'All']], '', () => this.show());
  private events: Event[] = [];
  private abort: AbortController | undefined;
  private problem = '';
  private upTo = '';

  constructor(private readonly app: App) {
    this.element = h('div', {}, section('Events', this.kind.element, this.robot.element, this.list));
  }

  open(): void {
    if (this.abort) return;
    this.abort = new AbortController();
    void this.follow(this.abort.signal);
  }

  close(): void {
    this.abort?.abort();
    this.abort = undefined;
  }

  private async follow(signal: AbortSignal): Promise<void> {
    const backoff = new Backoff();
    while (!signal.aborted) {
      try {
        if (!this.upTo) {
          const {events, upTo} = await this.app.calls.events(FIRST);
          this.take(events, upTo);
        }
        for await (const {events, upTo} of this.app.calls.watchEvents(this.upTo, signal)) {
          backoff.reset();
          this.take(events, upTo);
        }
      } catch (error) {
        if (isAbort(error)) return;
        this.problem = message(error);
        this.show();
        const denied = error instanceof RpcError && error.code === 'PERMISSION_DENIED';
        if (denied) return;
        // Another log than before: read it from its end.
        if (error instanceof RpcError && error.code === 'OUT_OF_RANGE') this.upTo = '';
      }
      await sleep(backoff.delayMs(), signal);
    }
  }

  private take(events: Event[], upTo: string): void {
    this.problem = '';
    this.upTo = upTo;
    const known = new Set(this.events.map((event) => event.number));
    this.events.unshift(...events.filter((event) => !known.has(event.number)).reverse());
    this.events.length = Math.min(this.events.length, KEPT);
    this.show();
  }

  private show(): void {
    const options = (first: string, values: string[], name: (v: string) => string) =>
        [['', first] as const, ...[...new Set(values)].filter(Boolean).sort().map(
            (value) => [value, name(value)] as const)];
    setOptions(this.kind.select, options('All kinds', this.events.map((e) => e.kind), words),
               this.kind.select.value);
    setOptions(this.robot.select, options('All', this.events.map((e) => e.robot), (r) => r),
               this.robot.select.value);
    const now = Date.now();
    const shown = this.events.filter((event) =>
      (!this.kind.select.value || event.kind === this.kind.select.value) &&
      (!this.robot.select.value || event.robot === this.robot.select.value)).slice(0, 500);
    fill(this.list, this.problem ? h('p', {class: 'poor'}, this.problem) : undefined,
         ...shown.map((event) => line(event, now)));
    if (shown.length === 0 && !this.problem) this.list.append(hint('Nothing has happened.'));
  }
}

function line(event: Event, nowMs: number): HTMLElement {
  const text = event.who ? `${event.text} (${event.who})` : event.text;
  return h('div', {class: 'row'}, h('span', {class: 'side'}, String(event.number)),
           words(event.kind), h('span', {class: 'side'}, moment(event.timeMs, nowMs)),
           h('span', {class: 'sub'}, text));
}
