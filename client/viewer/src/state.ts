// A value that others may watch.
export class Signal<T> {
  private readonly watchers = new Set<(value: T) => void>();

  constructor(private current: T) {}

  get value(): T {
    return this.current;
  }

  set(value: T): void {
    this.current = value;
    for (const watcher of [...this.watchers]) watcher(value);
  }

  // Told now and after each change.
  watch(watcher: (value: T) => void): void {
    this.watchers.add(watcher);
    watcher(this.current);
  }
}

// Reads a setting that the page remembers from one visit to the next. Without storage it remembers
// nothing.
export function recall(key: string, otherwise: string): string {
  try {
    return localStorage.getItem(`isthmus.${key}`) ?? otherwise;
  } catch {
    return otherwise;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(`isthmus.${key}`, value);
  } catch {
    // A private window: the setting holds until the page is closed.
  }
}
