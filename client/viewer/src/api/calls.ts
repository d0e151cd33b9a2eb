// The calls that the viewer makes, by name.
import {writePose, type Pose} from './geometry';
import {messages, obj, str, type JsonObject} from './json';
import * as m from './messages';
import type {Rpc} from './rpc';
import type {NewAnchor} from './views';

export type Decision = 'ACCEPT' | 'REJECT' | 'SET' | 'WITHDRAW';

export interface Diff {from: number; to: number; revisions: m.Revision[]; moves: m.SubmapMove[]}

export class Calls {
  constructor(readonly rpc: Rpc) {}

  async mapInfo(): Promise<m.MapInfo> {
    return m.readMapInfo(await this.rpc.call('MapService/GetMapInfo', {}));
  }

  async status(): Promise<m.ServerStatus> {
    return m.readServerStatus(await this.rpc.call('AdminService/GetStatus', {}));
  }

  // Goes on behind `revision` of `run`; from the beginning where they are 0.
  async *watchMap(revision: number, run: string, signal: AbortSignal):
      AsyncGenerator<m.WatchMapResponse> {
    const request = {fromRevision: String(revision), run, level: 0};
    for await (const o of this.rpc.stream('MapService/WatchMap', request, signal)) {
      yield m.readWatchMapResponse(o);
    }
  }

  async submaps(): Promise<m.Submap[]> {
    return this.all('MapService/ListSubmaps', {}, 'submaps', m.readSubmap);
  }

  async matches(): Promise<m.Match[]> {
    return this.all('MapService/GetMatchGraph', {}, 'matches', m.readMatch);
  }

  // In order of creation, each followed by its later segments.
  async sessions(): Promise<m.Session[]> {
    return this.all('SessionService/ListSessions', {}, 'sessions', m.readSession);
  }

  // The name of the token that the page is logged in with; empty where the server asks for none.
  async ownToken(): Promise<string> {
    return str((await this.rpc.call('AccessService/GetOwnToken', {}))['name']);
  }

  async loops(): Promise<m.Loop[]> {
    return this.all('MapService/ListLoops', {}, 'loops', m.readLoop);
  }

  async anchors(): Promise<m.Anchor[]> {
    return this.all('MapService/ListAnchors', {}, 'anchors', m.readAnchor);
  }

  async revisions(limit: number): Promise<m.Revision[]> {
    return this.all('MapService/ListRevisions', {limit}, 'revisions', m.readRevision);
  }

  // Poses in the map frame, in order of time, of the session that a robot opened.
  async trajectory(session: string): Promise<{component: number; poses: m.StampedPose[]}> {
    const asked = {robot: session, frame: 'MAP', segment: 0};
    const responses = await this.rpc.list('MapService/GetTrajectory', asked);
    return {
      component: Number(responses[0]?.['component'] ?? 0),
      poses: responses.flatMap((o) => messages(o['poses'], m.readStampedPose)),
    };
  }

  async diff(from: number, to: number): Promise<Diff> {
    const request = {fromRevision: String(from), toRevision: String(to)};
    const responses = await this.rpc.list('MapService/DiffRevisions', request);
    return {
      from,
      to,
      revisions: responses.flatMap((o) => messages(o['revisions'], m.readRevision)),
      moves: responses.flatMap((o) => messages(o['moves'], m.readSubmapMove)),
    };
  }

  async events(limit: number): Promise<{events: m.Event[]; upTo: string}> {
    const responses = await this.rpc.list('EventService/ListEvents', {limit});
    return {
      events: responses.flatMap((o) => messages(o['events'], m.readEvent)),
      upTo: str(responses.at(-1)?.['upTo']) || '0',
    };
  }

  async *watchEvents(after: string, signal: AbortSignal):
      AsyncGenerator<{events: m.Event[]; upTo: string}> {
    for await (const o of this.rpc.stream('EventService/WatchEvents', {after}, signal)) {
      yield {events: messages(o['events'], m.readEvent), upTo: str(o['upTo']) || after};
    }
  }

  async decideMatch({sessionA, sessionB}: m.SessionPair, decision: Decision, note: string,
                    pose?: Pose): Promise<m.Match> {
    const request: JsonObject = {sessionA, sessionB, decision, note};
    if (pose) request['tAB'] = writePose(pose);
    return m.readMatch(obj((await this.rpc.call('EditService/DecideMatch', request))['match']));
  }

  async decideLoop(id: number, decision: 'REJECT' | 'RESTORE', note: string): Promise<void> {
    await this.rpc.call('EditService/DecideLoop', {id, decision, note});
  }

  async putAnchor({tMapSubmap, ...rest}: NewAnchor): Promise<void> {
    const anchor = {...rest, tMapSubmap: writePose(tMapSubmap)};
    await this.rpc.call('EditService/PutAnchor', {anchor});
  }

  async deleteAnchor(session: string, index: number): Promise<void> {
    await this.rpc.call('EditService/DeleteAnchor', {session, index});
  }

  async undoRevision(revision: number, note: string): Promise<void> {
    await this.rpc.call('EditService/UndoRevision', {revision: String(revision), note});
  }

  private async all<T>(
      method: string, request: JsonObject, field: string, read: (o: JsonObject) => T):
      Promise<T[]> {
    const responses = await this.rpc.list(method, request);
    return responses.flatMap((o) => messages(o[field], read));
  }
}
