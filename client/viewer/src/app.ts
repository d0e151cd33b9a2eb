// The state that the parts of the page share: the map as it is known, the view of it, what is
// chosen, and what a person does about it.
import {Matrix4, Vector3} from 'three';
import {Calls} from './api/calls';
import type {Loop, Match, Revision, Submap} from './api/messages';
import {message, RpcError, type Rpc} from './api/rpc';
import {isUndecided, pairKey, poseOf, titleOf} from './api/views';
import {Model} from './model';
import {Region} from './region';
import {findCeiling} from './scene/ceiling';
import {Labels} from './scene/labels';
import {Look} from './scene/look';
import {Marks} from './scene/marks';
import {pick, type Picked} from './scene/pick';
import {centre, matrix, vector} from './scene/poses';
import {View} from './scene/view';
import type {Place} from './robots';
import {Signal} from './state';
import {TileLayer} from './tiles/layer';
import {TileTree} from './tiles/tree';
import {Align, mapTransform} from './tools/align';
import {LaidMap} from './tools/laid';
import type {Pointer, Tool} from './tools/tool';
import {Trails} from './trails';
import {askNote, Toasts} from './ui/dialogs';
import {Rights} from './ui/rights';

const CEILING_SAMPLES = 100_000;  // Points, at most; some ms.
const VOXEL_M = 0.1;  // The composed map's voxel unless the server was told otherwise.

export class App {
  readonly calls: Calls;
  readonly model: Model;
  readonly view: View;
  readonly labels: Labels;
  readonly marks: Marks;
  readonly look: Look;
  readonly region = new Region();
  readonly toasts = new Toasts();
  readonly rights = new Rights();
  readonly trails: Trails;
  readonly tool = new Signal<Tool | undefined>(undefined);
  readonly match = new Signal<Match | undefined>(undefined);
  readonly submap = new Signal<Submap | undefined>(undefined);
  readonly loop = new Signal<Loop | undefined>(undefined);
  readonly hidden = new Signal<Set<string>>(new Set());
  readonly drawn = new Signal<{points: number; tiles: number; pending: number}>(
      {points: 0, tiles: 0, pending: 0});
  onShowTab: (tab: string) => void = () => undefined;
  private layer: TileLayer | undefined;
  private readonly laid: LaidMap;
  private accepting: Match | undefined;  // While a person is asked whether to.
  private framed = -1;

  constructor(readonly rpc: Rpc, canvas: HTMLCanvasElement) {
    this.calls = new Calls(rpc);
    this.model = new Model(this.calls);
    this.view = new View(canvas);
    this.labels = new Labels(this.view);
    this.marks = new Marks(this.view, this.labels, this.model);
    this.look = new Look(this.view, this.model.numbers);
    this.trails = new Trails(this.model);
    this.laid = new LaidMap(rpc, this.view, this.model.numbers);
    this.model.onError = (error) => this.failed(error);
    this.wire();
  }

  private wire(): void {
    const {model, marks, view} = this;
    model.component.watch(() => this.useComponent());
    model.tiles.watch(() => this.tilesChanged());
    model.info.watch(() => this.frameOnce());
    model.status.watch((status) => this.rights.take(status?.refused ?? []));
    const remark = () => this.remark();
    for (const signal of [model.submaps, model.matches, model.loops, model.anchors]) {
      (signal as Signal<unknown>).watch(remark);
    }
    model.submaps.watch(() => this.findCeiling());
    model.robots.watch((robots) => {
      this.trails.extend(robots);
      marks.robots(robots, this.hidden.value);
    });
    this.trails.paths.watch((paths) => marks.trails(paths, this.hidden.value));
    this.match.watch((match) => this.chooseMatch(match));
    for (const signal of [this.tool, model.matches, model.sessions, model.tiles]) {
      (signal as Signal<unknown>).watch(() => this.preview());
    }
    this.submap.watch((submap) => marks.submaps(submap));
    this.loop.watch((loop) => marks.loops(loop?.id));
    this.hidden.watch((hidden) => (this.look.hide(hidden), remark()));
    this.region.state.watch(() => {
      this.region.apply(view.uniforms);
      if (this.layer) this.look.measure(this.layer);
      view.draw();
    });
    marks.onPickMatch = (match) => (this.match.set(match), this.onShowTab('graph'));
    marks.onPickSubmap = (submap) => (this.submap.set(submap), this.onShowTab('graph'));
    marks.onPickRobot = () => this.onShowTab('robots');
    view.onFrame = () => this.frame();
  }

  // All marks anew.
  remark(): void {
    const {marks} = this;
    marks.robots(this.model.robots.value, this.hidden.value);
    marks.trails(this.trails.paths.value, this.hidden.value);
    marks.submaps(this.submap.value);
    marks.graph(this.match.value);
    marks.loops(this.loop.value?.id);
    marks.anchors();
  }

  failed(error: unknown): void {
    this.model.live.failed(error);
    const quiet = error instanceof RpcError && ['UNAVAILABLE', 'UNAUTHENTICATED'].includes(error.code);
    // The connection's own notice tells of those.
    if (!quiet) this.toasts.show(message(error), true);
  }

  use(tool: Tool | undefined): void {
    this.tool.value?.end();
    this.tool.set(tool);
  }

  pick(at: Pointer): Picked | undefined {
    const layers = [this.layer, this.laid.layer].filter((layer) => layer !== undefined);
    return pick(this.view, layers, at.x, at.y);
  }

  showAll(): void {
    const bounds = this.model.shownComponent()?.bounds;
    if (bounds) this.view.frame(bounds);
  }

  // Takes the view to a place, into another map if it has to.
  goTo({component, pose}: Place): void {
    if (component !== this.model.component.value) this.model.component.set(component);
    this.view.lookAt(vector(pose.translation));
  }

  toggleRobot(robot: string, shown: boolean): void {
    const hidden = new Set(this.hidden.value);
    if (shown) hidden.delete(robot);
    else hidden.add(robot);
    this.hidden.set(hidden);
  }

  // Tells the server; says how it went; true where it worked.
  async act(done: string, action: () => Promise<unknown>): Promise<boolean> {
    try {
      await action();
      this.toasts.show(done);
      await this.model.refreshNow();
      return true;
    } catch (error) {
      this.failed(error);
      return false;
    }
  }

  async decide(match: Match, decision: 'ACCEPT' | 'REJECT' | 'WITHDRAW'): Promise<void> {
    const titles = {
      ACCEPT: ['Accept this match?', 'The transform found last holds from now on.', 'Accept'],
      REJECT: ['Reject this match?', 'The pair is not joined, whatever is computed.', 'Reject'],
      WITHDRAW: ['Withdraw the decision?', 'What the server computes counts again.', 'Withdraw'],
    } as const;
    const [title, text, action] = titles[decision];
    if (decision === 'ACCEPT') {
      this.accepting = match;
      this.showMapOf(match);
    }
    const note = await askNote(title, `${titleOf(match)}. ${text}`, action);
    this.accepting = undefined;
    // After a cancel the map is seen as it is.
    if (note === undefined && decision === 'ACCEPT') this.match.set(undefined);
    if (note === undefined) return;
    await this.act(`${titleOf(match)}: told the server.`,
                   () => this.calls.decideMatch(match, decision, note));
  }

  // A match that may be accepted as it would hold then: b's map lies on a's, bright, while the match
  // is chosen and undecided, or a person is asked whether to accept it.
  private preview(): void {
    if (this.tool.value?.name === 'align') return;
    const match = this.accepting ?? this.chosenMatch();
    const a = match && this.model.placement(match.sessionA);
    const b = match && this.model.placement(match.sessionB);
    const tree = b && this.model.tiles.value.get(b.component);
    const shown = this.accepting !== undefined || (match && isUndecided(match));
    const pose = match && poseOf(match);
    if (!shown || !pose || !tree || a?.component !== this.model.component.value) {
      return this.laid.clear();
    }
    this.laid.lay(tree, match.robotB, a.component === b.component);
    this.laid.move(mapTransform(a, matrix(pose), b));
  }

  // As the server has it now.
  private chosenMatch(): Match | undefined {
    const chosen = this.match.value;
    return chosen && this.model.matches.value.find(
        (match) => pairKey(match) === pairKey(chosen));
  }

  private chooseMatch(match: Match | undefined): void {
    if (match && isUndecided(match)) this.showMapOf(match);
    else this.preview();
    this.marks.graph(match);
  }

  // Shows the map that the match's preview is in.
  private showMapOf(match: Match): void {
    const a = this.model.placement(match.sessionA);
    if (a && a.component !== this.model.component.value) this.model.component.set(a.component);
    this.preview();
  }

  async decideLoop(loop: Loop): Promise<void> {
    const decision = loop.rejected ? 'RESTORE' : 'REJECT';
    const verb = loop.rejected ? 'Let it count again' : 'Reject';
    const note = await askNote(`${verb}?`, `Loop closure ${loop.id}, ${loop.session}/` +
        `${loop.submapA} and ${loop.submapB}.`, verb);
    if (note === undefined) return;
    await this.act(`Loop closure ${loop.id}: told the server.`,
                   () => this.calls.decideLoop(loop.id, decision, note));
  }

  async undo(revision: Revision): Promise<void> {
    const what = [...revision.matches.map((pair) => `match ${titleOf(pair)}`),
                  ...revision.loops.map((id) => `loop closure ${id}`)].join(', ');
    const note = await askNote(`Undo revision ${revision.revision}?`,
                               `Rejects ${what}, until that is taken back.`, 'Undo');
    if (note === undefined) return;
    await this.act(`Revision ${revision.revision} is undone.`,
                   () => this.calls.undoRevision(revision.revision, note));
  }

  // Lays b's map onto a's; where the two are in one map already, b's points alone move.
  align(match: Match): void {
    const a = this.model.placement(match.sessionA);
    const b = this.model.placement(match.sessionB);
    if (!a || !b) {
      this.toasts.show('One of the two has not been placed yet: it has no submap so far.', true);
      return;
    }
    if (this.model.component.value !== a.component) this.model.component.set(a.component);
    const tree = this.model.tiles.value.get(b.component) ?? new TileTree(b.component);
    const bounds = tree.roots[0]?.bounds;
    const pivot = b.component === a.component || !bounds ?
        new Vector3().setFromMatrixPosition(matrix(b.pose)) : centre(bounds);
    const found = a.component === b.component ? undefined : poseOf(match);
    const start = found ? mapTransform(a, matrix(found), b) : new Matrix4();
    this.use(undefined);
    this.laid.lay(tree, match.robotB, a.component === b.component);
    const tool = new Align({
      view: this.view, title: `${match.sessionB} onto ${match.sessionA}`, a, b, pivot, start,
      lay: (to) => this.laid.move(to),
      set: async (pose) => {
        const note = await askNote('Set this?', `${match.sessionB} lies on ${match.sessionA} as shown, ` +
            'whatever is computed.', 'Set');
        if (note === undefined) return;
        const told = await this.act(`${titleOf(match)}: told the server.`,
            () => this.calls.decideMatch(match, 'SET', note, pose));
        if (told) this.use(undefined);
      },
      close: () => this.use(undefined),
    });
    const end = tool.end.bind(tool);
    tool.end = () => (end(), this.laid.clear());
    this.view.setMode('top');
    this.use(tool);
  }

  private useComponent(): void {
    this.use(undefined);
    this.region.change({ceilingZ: undefined});
    this.layer?.dispose();
    this.layer = undefined;
    this.tilesChanged();
    this.remark();
    this.frameOnce();
  }

  private tree: TileTree | undefined;

  private tilesChanged(): void {
    const tree = this.model.tiles.value.get(this.model.component.value);
    if (!this.layer || tree !== this.tree) {
      this.layer?.dispose();
      this.layer = undefined;
      this.tree = tree;
      if (!tree) return this.view.draw();
      this.layer = new TileLayer(this.rpc, tree, this.view.uniforms, this.model.numbers);
      this.layer.onChange = () => this.view.draw();
      this.layer.onError = (error) => this.failed(error);
      this.laid.onto(this.layer);
      this.view.scene.add(this.layer.group);
    }
    this.layer.refresh();
    this.frameOnce();
    this.view.draw();
  }

  // The first time that there is something of a component to look at.
  private frameOnce(): void {
    const component = this.model.shownComponent();
    const bounds = component?.bounds;
    if (!bounds || this.framed === component.component) return;
    this.framed = component.component;
    this.view.setGrid(2 * Math.max(bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y));
    this.view.frame(bounds);
    if (!this.region.state.value.slice) this.region.change({sliceZ: bounds.min.z});
  }

  // From a view of all of the map: a part of it says nothing of the whole.
  private findCeiling(): void {
    const {layer} = this;
    if (!layer || layer.pending > 0 || layer.shownPoints === 0) return;
    const eye = this.view.eye();
    const submaps = this.model.submaps.value.filter(
        (s) => s.tMapSubmap && s.component === this.model.component.value);
    if (submaps.length === 0 || !this.tree?.isSeenWhole(eye.sees)) return;
    const sensorZ = Math.max(...submaps.map((s) => s.tMapSubmap!.translation.z));
    const ceilingZ = findCeiling(layer.sample(CEILING_SAMPLES), sensorZ);
    if (ceilingZ !== this.region.state.value.ceilingZ) this.region.change({ceilingZ});
  }

  private frame(): void {
    const eye = this.view.eye();
    const wish = {gapPx: this.look.gapPx, budget: this.look.budget, voxelM: VOXEL_M};
    this.layer?.update(eye, wish);
    this.laid.update(eye, {...wish, budget: wish.budget / 2});
    const {shownPoints = 0, shownTiles = 0, pending = 0} = this.layer ?? {};
    const before = this.drawn.value;
    if (before.points !== shownPoints || before.pending !== pending) {
      this.drawn.set({points: shownPoints, tiles: shownTiles, pending});
      if (this.layer) this.look.measure(this.layer);
      this.findCeiling();
    }
    this.marks.resize();
    this.labels.place();
  }
}
