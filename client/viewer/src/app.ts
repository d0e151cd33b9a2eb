// What the parts of the page share: the map as it is known, the view of it, what is chosen, and what
// a person does about it.
import {Matrix4, Vector3} from 'three';
import {Calls} from './api/calls';
import type {Loop, Match, Revision, Submap} from './api/messages';
import {message, RpcError, type Rpc} from './api/rpc';
import {Model} from './model';
import {Region} from './region';
import {Labels} from './scene/labels';
import {Look} from './scene/look';
import {Marks} from './scene/marks';
import {pick, type Picked} from './scene/pick';
import {centre, matrix} from './scene/poses';
import {View} from './scene/view';
import {Signal} from './state';
import {TileLayer} from './tiles/layer';
import {TileTree} from './tiles/tree';
import {Align, mapTransform} from './tools/align';
import type {Pointer, Tool} from './tools/tool';
import {Trails} from './trails';
import {askNote, Toasts} from './ui/dialogs';

const VOXEL_M = 0.1;  // Of the composed map unless the server was told otherwise.

export class App {
  readonly calls: Calls;
  readonly model: Model;
  readonly view: View;
  readonly labels: Labels;
  readonly marks: Marks;
  readonly look: Look;
  readonly region = new Region();
  readonly toasts = new Toasts();
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
  private laid: TileLayer | undefined;  // The map that is laid onto another.
  private framed = -1;

  constructor(readonly rpc: Rpc, canvas: HTMLCanvasElement) {
    this.calls = new Calls(rpc);
    this.model = new Model(this.calls);
    this.view = new View(canvas);
    this.labels = new Labels(this.view);
    this.marks = new Marks(this.view, this.labels, this.model);
    this.look = new Look(this.view, this.model.numbers);
    this.trails = new Trails(this.model);
    this.model.onError = (error) => this.failed(error);
    this.wire();
  }

  private wire(): void {
    const {model, marks, view} = this;
    model.component.watch(() => this.useComponent());
    model.tiles.watch(() => this.tilesChanged());
    model.info.watch(() => this.frameOnce());
    const remark = () => this.remark();
    for (const signal of [model.submaps, model.matches, model.loops, model.anchors]) {
      (signal as Signal<unknown>).watch(remark);
    }
    model.robots.watch((robots) => {
      this.trails.extend(robots);
      marks.robots(robots, this.hidden.value);
    });
    this.trails.paths.watch((paths) => marks.trails(paths, this.hidden.value));
    this.match.watch((match) => marks.graph(match));
    this.submap.watch((submap) => marks.submaps(submap));
    this.loop.watch((loop) => marks.loops(loop?.id));
    this.hidden.watch((hidden) => (this.look.hide(hidden), remark()));
    this.region.state.watch(() => (this.region.apply(view.uniforms), view.draw()));
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
    const layers = [this.layer, this.laid].filter((layer) => layer !== undefined);
    return pick(this.view, layers, at.x, at.y);
  }

  showAll(): void {
    const bounds = this.model.shownComponent()?.bounds;
    if (bounds) this.view.frame(bounds);
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
    const note = await askNote(title, `${match.a} ~ ${match.b}. ${text}`, action);
    if (note === undefined) return;
    await this.act(`${match.a} ~ ${match.b}: told the server.`,
                   () => this.calls.decideMatch(match.a, match.b, decision, note));
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
    const what = [...revision.matches.map(([a, b]) => `match ${a} ~ ${b}`),
                  ...revision.loops.map((id) => `loop closure ${id}`)].join(', ');
    const note = await askNote(`Undo revision ${revision.revision}?`,
                               `Rejects ${what}, until that is taken back.`, 'Undo');
    if (note === undefined) return;
    await this.act(`Revision ${revision.revision} is undone.`,
                   () => this.calls.undoRevision(revision.revision, note));
  }

  // Lays b's map onto a's; where the two are in one map already, b's points alone move.
  align(match: Match): void {
    const a = this.model.placement(match.a);
    const b = this.model.placement(match.b);
    if (!a || !b) {
      this.toasts.show('One of the two has not been placed yet: it has no submap so far.', true);
      return;
    }
    if (this.model.component.value !== a.component) this.model.component.set(a.component);
    const tree = this.model.tiles.value.get(b.component) ?? new TileTree(b.component);
    const bounds = tree.roots[0]?.bounds;
    const pivot = b.component === a.component || !bounds ?
        new Vector3().setFromMatrixPosition(matrix(b.pose)) : centre(bounds);
    const start = a.component === b.component ? new Matrix4() :
        match.pose ? mapTransform(a, matrix(match.pose), b) : new Matrix4();
    this.use(undefined);
    this.lay(tree, match, a.component === b.component);
    const tool = new Align({
      view: this.view, a, b, pivot, start,
      lay: (to) => {
        this.laid!.group.matrix.copy(to);
        this.laid!.group.updateMatrixWorld(true);
      },
      set: async (pose) => {
        const note = await askNote('Set this?', `${b.session} lies on ${a.session} as shown, ` +
            'whatever is computed.', 'Set');
        if (note === undefined) return;
        const told = await this.act(`${a.session} ~ ${b.session}: told the server.`,
            () => this.calls.decideMatch(a.session, b.session, 'SET', note, pose));
        if (told) this.use(undefined);
      },
      close: () => this.use(undefined),
    });
    const end = tool.end.bind(tool);
    tool.end = () => (end(), this.unlay());
    this.view.setMode('top');
    this.use(tool);
  }

  private lay(tree: TileTree, match: Match, sameMap: boolean): void {
    const number = this.model.numbers.of(match.robotB);
    this.laid = new TileLayer(this.rpc, tree, this.view.uniforms, this.model.numbers);
    this.laid.onChange = () => this.view.draw();
    this.laid.look.tint.value.set(1, 0.85, 0.25, 0.75);
    this.laid.group.matrixAutoUpdate = false;
    if (sameMap) {
      this.laid.look.only.value = number;
      if (this.layer) this.layer.look.hidden.value = number;
    }
    this.view.scene.add(this.laid.group);
  }

  private unlay(): void {
    this.laid?.dispose();
    this.laid = undefined;
    if (this.layer) this.layer.look.hidden.value = -1;
    this.view.draw();
  }

  private useComponent(): void {
    this.use(undefined);
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

  private frame(): void {
    const eye = this.view.eye();
    const wish = {gapPx: this.look.gapPx, budget: this.look.budget, voxelM: VOXEL_M};
    this.layer?.update(eye, wish);
    if (this.laid) {
      const to = this.laid.group.matrix;
      const moved = moveEye(eye, to);
      this.laid.update(moved, {...wish, budget: wish.budget / 2});
    }
    const {shownPoints = 0, shownTiles = 0, pending = 0} = this.layer ?? {};
    const before = this.drawn.value;
    if (before.points !== shownPoints || before.pending !== pending) {
      this.drawn.set({points: shownPoints, tiles: shownTiles, pending});
      if (this.layer) this.look.measure(this.layer);
    }
    this.marks.resize();
    this.labels.place();
  }
}

// As the view looks at a map that was laid somewhere: all of its tiles count as seen.
function moveEye(eye: ReturnType<View['eye']>, to: Matrix4): ReturnType<View['eye']> {
  const {x, y, z} = eye.position;
  const at = new Vector3(x, y, z).applyMatrix4(to.clone().invert());
  return {...eye, position: {x: at.x, y: at.y, z: at.z}, sees: () => true};
}
