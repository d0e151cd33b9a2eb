// Where a robot is: its newest session answers for it, as everywhere.
import type {Pose} from './api/geometry';
import type {RobotPlace, Session, Submap} from './api/messages';

// In a map, by the number that it has now.
export interface Place {component: number; pose: Pose}

// Undefined for a robot that has none, as one that was localised alone.
export function newestSession(robot: string, sessions: Session[]): Session | undefined {
  return sessions.filter((session) => session.robot === robot).at(-1);
}

// Where its newest session is now, else where it is found in the map of others, else where that
// session's last submap lies. Undefined: in no map.
export function placeOf(robot: string, session: Session | undefined, robots: RobotPlace[],
                        submaps: Submap[]): Place | undefined {
  const own = robots.filter((one) => one.robot === robot);
  const mapped = submaps.filter((submap) => submap.session === session?.id);
  return [...own.filter((one) => session && one.session === session.id),
          ...own.filter((one) => one.localising)].map((one) => asPlace(one.component, one.tMapSensor))
      .concat(mapped.reverse().map((one) => asPlace(one.component, one.tMapSubmap)))
      .find((place) => place !== undefined);
}

export function asPlace(component: number | undefined, pose: Pose | undefined): Place | undefined {
  return component === undefined || !pose ? undefined : {component, pose};
}
