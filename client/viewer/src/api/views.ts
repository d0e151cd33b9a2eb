// Facts that the page derives from the messages of the API.
import type {Pose} from './geometry';
import {readMatch, type Anchor, type Match, type MatchState, type Session, type TileId}
  from './messages';

// The place of a session that has been placed.
export interface Placement {
  component: number;
  pose: Pose;  // T_map_odom at its newest submap.
}

export function placementOf({component, tMapOdom}: Session): Placement | undefined {
  return component === undefined || !tMapOdom ? undefined : {component, pose: tMapOdom};
}

// The session that the robot opened: "alice-1" for the segment "alice-1.2".
export function openedAs(session: Session): string {
  return session.firstSegment || session.id;
}

export function stateOf(match: Match): Exclude<MatchState, ''> {
  return match.state || 'NOT_YET';
}

// T_a_b of the odom frames. A match for which nothing was found has none.
export function poseOf(match: Match): Pose | undefined {
  return match.matcher || match.manualDecision ? match.tAB : undefined;
}

// Something was found between the two that neither a person nor the server has accepted or rejected
// for good: by hand alone is for good.
export function isUndecided(match: Match): boolean {
  return poseOf(match) !== undefined && match.state !== 'ACCEPTED' && !match.manualDecision;
}

// The match of two sessions for which nothing was found yet.
export function emptyMatch(pair: Pick<Match, 'sessionA' | 'sessionB' | 'robotA' | 'robotB'>): Match {
  return {...readMatch({}), ...pair};
}

export function titleOf({sessionA, sessionB}: {sessionA: string; sessionB: string}): string {
  return `${sessionA} ~ ${sessionB}`;
}

// One for both directions of a pair.
export function pairKey({sessionA, sessionB}: {sessionA: string; sessionB: string}): string {
  return [sessionA, sessionB].sort().join(' ~ ');
}

export type NewAnchor = Omit<Anchor, 'robot' | 'givenMs'>;

export function tileKey(id: TileId): string {
  return `${id.component}/${id.level}/${id.x}/${id.y}`;
}
