// The watch on the map: begins again, ever more slowly, when it breaks, and goes on behind what it
// had whole.
import type {Calls} from './api/calls';
import type {WatchMapResponse} from './api/messages';
import {isAbort, RpcError} from './api/rpc';
import {Backoff, sleep} from './retry';
import {Signal} from './state';

const NO_ACCESS = ['UNAUTHENTICATED', 'PERMISSION_DENIED'];  // Another token is needed.

export type Connection =
    | {state: 'connecting' | 'live'}
    | {state: 'lost'; why: string; againMs: number}
    | {state: 'login'; why: string};

export class Live {
  readonly connection = new Signal<Connection>({state: 'connecting'});
  private readonly backoff = new Backoff();
  private abort = new AbortController();
  private waiting = new AbortController();
  private revision = 0;
  private run = '0';

  constructor(private readonly calls: Calls,
              private readonly onChange: (change: WatchMapResponse, first: boolean) => void) {}

  start(): void {
    this.abort.abort();
    this.abort = new AbortController();
    this.backoff.reset();
    void this.follow(this.abort.signal);
  }

  // Does not wait any longer for the next attempt.
  retryNow(): void {
    this.waiting.abort();
  }

  // Callers report here that the server is gone or wants a token.
  failed(error: unknown): void {
    if (!(error instanceof RpcError) || this.connection.value.state !== 'live') return;
    if (error.code === 'UNAVAILABLE' || error.code === 'UNAUTHENTICATED') this.start();
  }

  private async follow(signal: AbortSignal): Promise<void> {
    if (this.connection.value.state !== 'lost') this.connection.set({state: 'connecting'});
    while (!signal.aborted) {
      let error: unknown;
      try {
        await this.watch(signal);
        error = new RpcError('UNAVAILABLE', 'The server ended the connection.');
      } catch (caught) {
        error = caught;
      }
      if (signal.aborted || isAbort(error)) return;
      if (error instanceof RpcError && NO_ACCESS.includes(error.code)) {
        // The error says how programs send a token, which is of no use to a person at the page.
        const why = error.code === 'UNAUTHENTICATED' ? '' : error.message;
        this.connection.set({state: 'login', why});
        return;
      }
      await this.pause(error, signal);
    }
  }

  private async watch(signal: AbortSignal): Promise<void> {
    let first = true;
    for await (const change of this.calls.watchMap(this.revision, this.run, signal)) {
      if (signal.aborted) return;
      this.backoff.reset();
      this.onChange(change, first);
      first = false;
      if (!change.more) [this.revision, this.run] = [change.revision, change.run];
      if (this.connection.value.state !== 'live') this.connection.set({state: 'live'});
    }
  }

  private async pause(error: unknown, signal: AbortSignal): Promise<void> {
    const delay = this.backoff.delayMs(error instanceof RpcError ? error.retryAfterS : 0);
    const why = error instanceof Error ? error.message : String(error);
    this.connection.set({state: 'lost', why, againMs: Date.now() + delay});
    this.waiting = new AbortController();
    signal.addEventListener('abort', () => this.waiting.abort(), {once: true});
    await sleep(delay, this.waiting.signal);
  }
}
