// The maps that there are, which have no known relation to each other.
import type {Component} from './api/messages';

const NAMED = 3;  // Robots; the names of more fill a line.

// A map's title: its number by now, its name, which stays, and its robots.
export function mapTitle({component, referenceSession, robots}: Component): string {
  const more = robots.length > NAMED ? ` and ${robots.length - NAMED} more` : '';
  return `Map ${component} (${referenceSession}): ${robots.slice(0, NAMED).join(', ')}${more}`;
}

// The number by now of the map that was shown: numbers follow the maps' sizes, its sessions stay.
export function numberNow(shown: Component | undefined, components: Component[]): number {
  for (const session of shown ? [shown.referenceSession, ...shown.sessions] : []) {
    const now = components.find((c) => c.sessions.includes(session));
    if (now) return now.component;
  }
  return 0;
}
