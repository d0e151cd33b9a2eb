// The wait before the next attempt to reach the server: 0.5 s, then ever longer up to 10 s, and
// longer still if the server asks for it.
const FIRST_MS = 500;
const LONGEST_MS = 10_000;

export class Backoff {
  private next = FIRST_MS;

  reset(): void {
    this.next = FIRST_MS;
  }

  delayMs(retryAfterS = 0): number {
    const delay = Math.max(this.next, retryAfterS * 1000);
    this.next = Math.min(2 * this.next, LONGEST_MS);
    return delay;
  }
}

// Ends early, without an error, when `signal` is aborted.
export function sleep(ms: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    if (signal.aborted) return resolve();
    const timer = setTimeout(resolve, ms);
    signal.addEventListener('abort', () => (clearTimeout(timer), resolve()), {once: true});
  });
}
