// The page's knowledge of the map, kept up to date: by the watch at once, by lists soon after.
import type {Calls} from './api/calls';
import type {Anchor, Loop, MapInfo, Match, Revision, RobotPlace, ServerStatus, Session, Submap,
             WatchMapResponse} from './api/messages';
import {isAbort} from './api/rpc';
import {placementOf, type Placement} from './api/views';
import {RobotNumbers} from './scene/colours';
import {Live} from './live';
import {numberNow} from './maps';
import {Signal} from './state';
import {TileTree} from './tiles/tree';

// Lists follow the watch after this, so that a server that maps fast is not asked all the time.
const LISTS_AFTER_MS = 400;
const LISTS_EVERY_MS = 3000;
const REVISIONS = 1000;

export class Model {
  readonly live: Live;
  readonly numbers = new RobotNumbers();
  readonly info = new Signal<MapInfo | undefined>(undefined);
  readonly status = new Signal<ServerStatus | undefined>(undefined);
  readonly submaps = new Signal<Submap[]>([]);
  readonly matches = new Signal<Match[]>([]);
  readonly sessions = new Signal<Session[]>([]);
  readonly loops = new Signal<Loop[]>([]);
  readonly anchors = new Signal<Anchor[]>([]);
  readonly revisions = new Signal<Revision[]>([]);
  readonly robots = new Signal<RobotPlace[]>([]);
  readonly component = new Signal<number>(0);
  // The tiles of each component, level 0, have changed.
  readonly tiles = new Signal<Map<number, TileTree>>(new Map());
  onError: (error: unknown) => void = () => undefined;
  private inStep = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private listedMs = 0;

  constructor(readonly calls: Calls) {
    this.live = new Live(calls, (change, first) => this.take(change, first));
  }

  placement(session: string): Placement | undefined {
    const found = this.sessions.value.find(({id}) => id === session);
    return found && placementOf(found);
  }

  shownComponent(): MapInfo['components'][number] | undefined {
    return this.info.value?.components.find((c) => c.component === this.component.value);
  }

  // Asks for all lists, soon.
  refresh(): void {
    if (this.timer !== undefined) return;
    const wait = Math.max(LISTS_AFTER_MS, this.listedMs + LISTS_EVERY_MS - Date.now());
    this.timer = setTimeout(() => void this.readLists(), wait);
  }

  // At once: after what a person did.
  async refreshNow(): Promise<void> {
    clearTimeout(this.timer);
    await this.readLists();
  }

  async readStatus(): Promise<void> {
    try {
      const status = await this.calls.status();
      const open = (of: ServerStatus | undefined) => of?.sessions.map((s) => s.session).join();
      // One was opened or finished, which the watch on the map does not tell.
      if (open(status) !== open(this.status.value)) this.refresh();
      this.status.set(status);
    } catch (error) {
      this.onError(error);
    }
  }

  private async readLists(): Promise<void> {
    const {calls} = this;
    try {
      const [info, submaps, sessions, matches, loops, anchors, revisions] = await Promise.all([
        calls.mapInfo(), calls.submaps(), calls.sessions(), calls.matches(), calls.loops(),
        calls.anchors(), calls.revisions(REVISIONS),
      ]);
      info.robots.forEach((robot) => this.numbers.of(robot));
      const shown = numberNow(this.shownComponent(), info.components);
      this.info.set(info);
      this.submaps.set(submaps);
      this.sessions.set(sessions);
      this.matches.set(matches);
      this.loops.set(loops);
      this.anchors.set(anchors);
      this.revisions.set(revisions);
      if (shown !== this.component.value) this.component.set(shown);
    } catch (error) {
      if (!isAbort(error)) this.onError(error);
    } finally {
      this.listedMs = Date.now();
      this.timer = undefined;
    }
  }

  // `first`: of a new watch; what an earlier one began is not gone on with.
  private take(change: WatchMapResponse, first: boolean): void {
    const trees = this.tiles.value;
    if (change.restart && (first || !this.inStep)) trees.clear();
    this.inStep = change.more;
    const components = new Set([...change.tiles.map((tile) => tile.id.component),
                                ...change.removedTiles.map((id) => id.component)]);
    for (const component of components) {
      const tree = trees.get(component) ?? new TileTree(component);
      trees.set(component, tree);
      tree.update(change.tiles, change.removedTiles);
    }
    if (change.hasRobots) this.robots.set(change.robots);
    if (components.size > 0 || change.restart) this.tiles.set(trees);
    const lists = change.submaps.length + change.matches.length + change.removedMatches.length;
    if (lists > 0 || components.size > 0 || change.restart) this.refresh();
  }
}
