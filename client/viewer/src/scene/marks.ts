// The marks over the points: robots and their trails, submaps, the match graph, loops, anchors, and
// what a revision moved.
import {ConeGeometry, Group, Mesh, MeshBasicMaterial, Object3D, Vector3} from 'three';
import type {Pose} from '../api/geometry';
import type {Match, RobotPlace, StampedPose, Submap, SubmapMove} from '../api/messages';
import {pairKey, stateOf, titleOf} from '../api/views';
import type {Model} from '../model';
import {clear, lines, path} from './lines';
import type {Labels} from './labels';
import {matrix, vector} from './poses';
import type {View} from './view';
import {percent, UNNAMED, words} from '../ui/format';

export const STATE_COLOURS: Record<ReturnType<typeof stateOf>, string> = {
  ACCEPTED: '#43b783', REJECTED: '#ea6a6a', AMBIGUOUS: '#dea83d', NOT_YET: '#93a0af',
};
export const LOOP_COLOUR = '#c77ddb';
export const ANCHOR_COLOUR = '#4d9bf0';
export const MOVE_COLOUR = '#f0803c';
const ASKED_COLOUR = '#38c6d9';
const ARROW_PX = 22;
const ABOVE_M = 1.5;  // The graph's lines lie above the floors that they join.

export type MarkSet = 'robots' | 'trails' | 'submaps' | 'graph' | 'loops' | 'anchors';

export class Marks {
  readonly on: Record<MarkSet, boolean> =
      {robots: true, trails: true, submaps: false, graph: true, loops: false, anchors: true};
  onPickMatch: (match: Match) => void = () => undefined;
  onPickSubmap: (submap: Submap) => void = () => undefined;
  onPickRobot: (robot: string) => void = () => undefined;
  private readonly groups = new Map<string, Group>();

  constructor(private readonly view: View, private readonly labels: Labels,
              private readonly model: Model) {}

  private group(name: string): Group {
    let group = this.groups.get(name);
    if (!group) {
      group = new Group();
      this.groups.set(name, group);
      this.view.overlay.add(group);
    }
    clear(group);
    return group;
  }

  private here(component: number | undefined): boolean {
    return component === this.model.component.value;
  }

  robots(robots: RobotPlace[], hidden: Set<string>): void {
    const group = this.group('robots');
    const placed = robots.filter(
        (r) => this.on.robots && r.tMapSensor && this.here(r.component) && !hidden.has(r.robot));
    for (const {robot, tMapSensor} of placed) {
      group.add(arrow(tMapSensor!, this.model.numbers.colour(robot)));
    }
    this.labels.set('robots', placed.map((r) => ({
      text: [r.robot || UNNAMED, ...(r.localising ? ['localised'] : []),
             ...(r.lagMs > 2000 ? [`${Math.round(r.lagMs / 1000)} s behind`] : [])].join(' · '),
      at: vector(r.tMapSensor!.translation).add(new Vector3(0, 0, 0.6)),
      colour: this.model.numbers.colour(r.robot),
      onclick: () => this.onPickRobot(r.robot),
    })));
    this.view.draw();
  }

  // Robots are never smaller on the screen than can be seen. To be called with each frame.
  resize(): void {
    const eye = this.view.camera.position;
    for (const name of ['robots', 'mark']) {
      for (const arrow of this.groups.get(name)?.children ?? []) {
        const away = this.view.mode === 'top' ? 1 : eye.distanceTo(arrow.position);
        arrow.scale.setScalar(Math.max(1, (ARROW_PX * away) / this.view.pixelsPerMetre()));
      }
    }
  }

  trails(trails: Map<string, {component: number; poses: StampedPose[]}>, hidden: Set<string>): void {
    const group = this.group('trails');
    for (const [robot, {component, poses}] of trails) {
      if (!this.on.trails || !this.here(component) || hidden.has(robot) || poses.length < 2) continue;
      const points = poses.map(({pose}) => vector(pose.translation));
      group.add(lines(path(points), {colour: this.model.numbers.colour(robot), px: 2, through: true}));
    }
    this.view.draw();
  }

  submaps(selected: Submap | undefined): void {
    const group = this.group('submaps');
    const here = this.model.submaps.value.filter((s) => s.tMapSubmap && this.here(s.component));
    const shown = here.filter((s) => this.on.submaps || isSame(s, selected));
    AXES.forEach((colour, axis) => {
      const ends = shown.flatMap(
          (s) => axisEnds(s.tMapSubmap!, axis, isSame(s, selected) ? 2 : 1));
      if (ends.length > 0) group.add(lines(ends, {colour, px: 2, through: true}));
    });
    // More names than that nobody can read; the marks stay.
    const named = shown.length > 150 ? shown.filter((s) => isSame(s, selected)) : shown;
    this.labels.set('submaps', named.map((s) => ({
      text: `${s.session}/${s.index}`,
      at: vector(s.tMapSubmap!.translation),
      chosen: isSame(s, selected),
      onclick: () => this.onPickSubmap(s),
    })));
    this.view.draw();
  }

  graph(selected: Match | undefined): void {
    const group = this.group('graph');
    const middles = this.middles();
    const drawn = this.model.matches.value.flatMap((match) => {
      const [a, b] = [middles.get(match.sessionA), middles.get(match.sessionB)];
      const wanted = this.on.graph || isPair(match, selected);
      return a && b && wanted ? [{match, a, b}] : [];
    });
    for (const {match, a, b} of drawn) {
      group.add(lines([a, b], {
        colour: STATE_COLOURS[stateOf(match)],
        px: isPair(match, selected) ? 5 : match.inTree ? 3 : 2,
        through: true,
        ...(match.inTree ? {} : {dashM: 0.6}),
      }));
    }
    this.labels.set('graph', drawn.map(({match, a, b}) => ({
      text: match.state === 'ACCEPTED' ?
          `${titleOf(match)} ${percent(match.confidence)}` :
          `${titleOf(match)}: ${words(match.reason || stateOf(match))}`,
      title: match.detail,
      at: a.clone().lerp(b, 0.5),
      colour: STATE_COLOURS[stateOf(match)],
      chosen: isPair(match, selected),
      onclick: () => this.onPickMatch(match),
    })));
    this.asked(selected);
    this.view.draw();
  }

  // The ways that robots of this map are asked to drive, solid from where they leave their own.
  private asked(selected: Match | undefined): void {
    const group = this.group('asked');
    const placed = new Set(this.model.sessions.value.filter((s) => this.here(s.component)).map((s) => s.id));
    const drives = this.model.matches.value.flatMap(
        (match) => this.on.graph || isPair(match, selected) ?
            match.askedDrives.map((drive) => ({match, drive})) : [])
        .filter(({drive}) => placed.has(drive.session) && drive.way.length > 0);
    for (const {match, drive} of drives) {
      const way = drive.way.map(vector);
      const stroke = {colour: ASKED_COLOUR, px: isPair(match, selected) ? 5 : 3, through: true};
      group.add(lines(path(way.slice(0, drive.leavesOwn + 1)), {...stroke, dashM: 0.6}));
      group.add(lines(path(way.slice(drive.leavesOwn)), stroke));
    }
    this.labels.set('asked', drives.map(({match, drive}) => ({
      text: `${drive.robot}: ${drive.lengthM.toFixed(0)} m to here`,
      title: `Would tell whether ${titleOf(match)} lie like that: ${percent(drive.confidence)} then`,
      at: vector(drive.way[drive.way.length - 1]!),
      colour: ASKED_COLOUR,
      chosen: isPair(match, selected),
      onclick: () => this.onPickMatch(match),
    })));
  }

  loops(selectedId: number | undefined): void {
    const group = this.group('loops');
    const places = this.places();
    for (const loop of this.model.loops.value) {
      const a = places.get(`${loop.session}/${loop.submapA}`);
      const b = places.get(`${loop.session}/${loop.submapB}`);
      if (!a || !b || (!this.on.loops && loop.id !== selectedId)) continue;
      group.add(lines([a, b], {
        colour: loop.rejected ? STATE_COLOURS.REJECTED : LOOP_COLOUR,
        px: loop.id === selectedId ? 5 : 2,
        through: true,
        ...(loop.rejected ? {dashM: 0.4} : {}),
      }));
    }
    this.view.draw();
  }

  anchors(): void {
    const group = this.group('anchors');
    const places = this.places();
    const labels = [];
    for (const anchor of this.on.anchors ? this.model.anchors.value : []) {
      const name = `${anchor.session}/${anchor.index}`;
      const at = places.get(name);
      if (!at) continue;
      const given = vector(anchor.tMapSubmap.translation);
      const up = given.clone().add(new Vector3(0, 0, 2));
      group.add(lines([given, up, given, at], {colour: ANCHOR_COLOUR, px: 3, through: true}));
      labels.push({text: `⚓ ${name}`, title: anchor.note, at: up, colour: ANCHOR_COLOUR});
    }
    this.labels.set('anchors', labels);
    this.view.draw();
  }

  // From where each submap was to where it came, of those in the frame that is shown.
  moves(moves: SubmapMove[]): void {
    const group = this.group('moves');
    const reference = this.model.shownComponent()?.referenceSession;
    const moved: Vector3[] = [];
    const came: Vector3[] = [];
    for (const move of moves) {
      if (!move.after || move.referenceAfter !== reference) continue;
      const after = vector(move.after.translation);
      if (move.before && move.referenceBefore === reference) {
        moved.push(vector(move.before.translation), after);
      } else {
        came.push(after, after.clone().add(new Vector3(0, 0, 2)));
      }
    }
    if (moved.length > 0) group.add(lines(moved, {colour: MOVE_COLOUR, px: 4, through: true}));
    if (came.length > 0) {
      group.add(lines(came, {colour: STATE_COLOURS.ACCEPTED, px: 4, through: true}));
    }
    this.view.draw();
  }

  // An arrow where something is about to be put.
  mark(pose: Pose | undefined): void {
    const group = this.group('mark');
    if (pose) group.add(arrow(pose, ANCHOR_COLOUR));
    this.view.draw();
  }

  private places(): Map<string, Vector3> {
    return new Map(this.model.submaps.value
                       .filter((s) => s.tMapSubmap && this.here(s.component))
                       .map((s) => [`${s.session}/${s.index}`, vector(s.tMapSubmap!.translation)]));
  }

  // The node of each session of the component: above the mean of its submaps' places.
  private middles(): Map<string, Vector3> {
    const sessions = new Map<string, Vector3[]>();
    for (const submap of this.model.submaps.value) {
      if (!submap.tMapSubmap || !this.here(submap.component)) continue;
      const places = sessions.get(submap.session) ?? [];
      places.push(vector(submap.tMapSubmap.translation));
      sessions.set(submap.session, places);
    }
    return new Map([...sessions].map(([session, places]) => {
      const sum = places.reduce((total, at) => total.add(at), new Vector3());
      const mean = sum.divideScalar(places.length);
      return [session, mean.add(new Vector3(0, 0, ABOVE_M))];
    }));
  }
}

function isSame(a: Submap, b: Submap | undefined): boolean {
  return a.session === b?.session && a.index === b.index;
}

function isPair(a: Match, b: Match | undefined): boolean {
  return b !== undefined && pairKey(a) === pairKey(b);
}

function arrow(pose: Pose, colour: string): Object3D {
  const material = new MeshBasicMaterial({color: colour, depthTest: false, transparent: true});
  const cone = new Mesh(new ConeGeometry(0.35, 1, 16).rotateZ(-Math.PI / 2), material);
  cone.renderOrder = 11;
  cone.applyMatrix4(matrix(pose));
  return cone;
}

const AXES = ['#ea6a6a', '#43b783', '#4d9bf0'];  // x, y, z.

function axisEnds(pose: Pose, axis: number, lengthM: number): Vector3[] {
  const direction = new Vector3().setFromMatrixColumn(matrix(pose), axis);
  const at = vector(pose.translation);
  return [at, at.clone().addScaledVector(direction, lengthM)];
}
