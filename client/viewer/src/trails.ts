// The trails of the robots: read anew when the map changes, in between extended by where they are.
import type {RobotPlace, StampedPose} from './api/messages';
import {RpcError} from './api/rpc';
import {openedAs} from './api/views';
import type {Model} from './model';
import {newestSession} from './robots';
import {Signal} from './state';

const EVERY_MS = 5000;
const AT_MOST = 5000;  // Poses of a trail that are drawn; of longer ones every second, and so on.

export interface Trail {component: number; poses: StampedPose[]}

export class Trails {
  readonly paths = new Signal<Map<string, Trail>>(new Map());
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readMs = 0;

  constructor(private readonly model: Model) {
    model.submaps.watch(() => this.refresh());
  }

  extend(robots: RobotPlace[]): void {
    const paths = this.paths.value;
    for (const robot of robots) {
      if (robot.localising) continue;  // Its trail is of what it added to the map.
      const trail = paths.get(robot.robot);
      if (!trail || !robot.tMapSensor || trail.component !== robot.component) continue;
      if (robot.stampMs > (trail.poses.at(-1)?.stampMs ?? 0)) {
        trail.poses.push({stampMs: robot.stampMs, pose: robot.tMapSensor});
      }
    }
    this.paths.set(paths);
  }

  private refresh(): void {
    if (this.timer !== undefined) return;
    const wait = Math.max(0, this.readMs + EVERY_MS - Date.now());
    this.timer = setTimeout(() => void this.read(), wait);
  }

  private async read(): Promise<void> {
    const paths = new Map<string, Trail>();
    // Others have no way in the map yet.
    const placed = this.model.submaps.value.filter((submap) => submap.tMapSubmap !== undefined);
    for (const robot of new Set(placed.map((submap) => submap.robot))) {
      // By its session: a robot may be called as another one's session is.
      const session = newestSession(robot, this.model.sessions.value);
      if (!session) continue;
      try {
        const {component, poses} = await this.model.calls.trajectory(openedAs(session));
        paths.set(robot, {component, poses: thin(poses, AT_MOST)});
      } catch (error) {
        // One that has gone meanwhile.
        const unplaced = error instanceof RpcError &&
            ['FAILED_PRECONDITION', 'NOT_FOUND'].includes(error.code);
        if (!unplaced) this.model.onError(error);
      }
    }
    this.readMs = Date.now();
    this.timer = undefined;
    this.paths.set(paths);
  }
}

export function thin<T>(items: T[], atMost: number): T[] {
  const step = Math.ceil(items.length / atMost);
  if (step <= 1) return items;
  return items.filter((_, i) => i % step === 0 || i === items.length - 1);
}
