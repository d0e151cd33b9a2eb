// The place of a robot: its newest session answers for it, as everywhere.
import type {Pose} from './api/geometry';
import type {RobotPlace, Session, Submap} from './api/messages';

// In a map, by the number that it has now.
export interface Place {component: number; pose: Pose}

// Undefined for a robot that has none, as one that was localised alone.
export function newestSession(robot: string, sessions: Session[]): Session | undefined {
  return sessions.filter((session) => session.robot === robot).at(-1);
}

// The place of the robot's newest session now, else the place found for the robot in the map of
// others, else that of the session's last submap that has one. Undefined: in no map.
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
