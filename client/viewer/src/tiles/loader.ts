// Fetches tiles, a few at a time, the ones asked for last first; asks for a tile that it has only
// whether it has changed.
import type {TileId} from '../api/messages';
import {isAbort, RpcError, type Rpc} from '../api/rpc';
import {parsePts2, type Points} from './pts2';

const AT_A_TIME = 6;     // Connections that a browser opens to one server.
const RETRY_MS = 3000;   // A tile that could not be had is asked for again after this.

export interface Tile {
  etag: string;
  robots: string[];
  points: Points;
}

export interface Want {
  key: string;
  id: TileId;
  change: number;
  etag: string;  // The version of the tile that is there already; empty: nothing.
}

// Takes the outcome of a want: a tile; null: what is there still holds; undefined: there is none.
export type Arrived = (want: Want, tile: Tile | null | undefined) => void;

export class TileLoader {
  private readonly running = new Map<string, AbortController>();
  private readonly failed = new Map<string, number>();
  private queue: Want[] = [];
  onIdle: () => void = () => undefined;
  onError: (error: RpcError) => void = () => undefined;

  constructor(private readonly rpc: Rpc, private readonly arrived: Arrived) {}

  get pending(): number {
    return this.queue.length + this.running.size;
  }

  // Replaces what was wanted; what is under way and wanted no more is called off.
  want(wants: Want[]): void {
    const keys = new Set(wants.map((want) => want.key));
    for (const [key, controller] of this.running) if (!keys.has(key)) controller.abort();
    const now = performance.now();
    this.queue = wants.filter(
        (want) => !this.running.has(want.key) && (this.failed.get(want.key) ?? 0) <= now);
    this.start();
  }

  stop(): void {
    this.want([]);
  }

  private start(): void {
    while (this.running.size < AT_A_TIME) {
      const want = this.queue.shift();
      if (!want) return;
      const controller = new AbortController();
      this.running.set(want.key, controller);
      void this.fetch(want, controller.signal).finally(() => {
        this.running.delete(want.key);
        this.start();
        if (this.pending === 0) this.onIdle();
      });
    }
  }

  private async fetch(want: Want, signal: AbortSignal): Promise<void> {
    const {component, level, x, y} = want.id;
    try {
      const headers: Record<string, string> = want.etag ? {'If-None-Match': want.etag} : {};
      const response =
          await this.rpc.get(`/tiles/${component}/${level}/${x}/${y}.pts`, headers, signal);
      if (response.status === 304) return this.arrived(want, null);
      const points = parsePts2(await response.arrayBuffer());
      if (signal.aborted) return;
      const robots = JSON.parse(response.headers.get('Isthmus-Robots') ?? '[]') as string[];
      this.failed.delete(want.key);
      this.arrived(want, {etag: response.headers.get('ETag') ?? '', robots, points});
    } catch (error) {
      if (isAbort(error) || signal.aborted) return;
      if (error instanceof RpcError && error.code === 'NOT_FOUND') {
        return this.arrived(want, undefined);
      }
      this.failed.set(want.key, performance.now() + RETRY_MS);
      this.onError(error instanceof RpcError ? error : new RpcError('UNKNOWN', String(error)));
    }
  }
}
