// The maps that there are, which have no known relation to each other.
import type {Component} from './api/messages';

// The number by now of the map that was shown: numbers follow the maps' sizes, its sessions stay.
export function numberNow(shown: Component | undefined, components: Component[]): number {
  for (const session of shown ? [shown.referenceSession, ...shown.sessions] : []) {
    const now = components.find((c) => c.sessions.includes(session));
    if (now) return now.component;
  }
  return 0;
}
