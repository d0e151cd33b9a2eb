// The view of the map: two cameras (orbit, and from above), their controls, and when to draw.
import {
  AmbientLight, Box3, Color, Frustum, GridHelper, Group, Matrix4, OrthographicCamera,
  PerspectiveCamera, Plane, Ray, Raycaster, Scene, Vector2, Vector3, WebGLRenderer, MOUSE, TOUCH,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import type {Box} from '../api/geometry';
import type {Eye} from '../tiles/select';
import {makeUniforms} from './point_material';

const FIELD_OF_VIEW_DEG = 50;
const NEAR_M = 0.2;
const FAR_M = 20_000;

export type ViewMode = 'orbit' | 'top';

export class View {
  readonly scene = new Scene();
  readonly overlay = new Group();  // Lines and marks, drawn over the points.
  readonly uniforms = makeUniforms();
  readonly renderer: WebGLRenderer;
  readonly controls: OrbitControls;
  mode: ViewMode = 'orbit';
  onFrame: () => void = () => undefined;
  onMove: () => void = () => undefined;
  private readonly perspective =
      new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, NEAR_M, FAR_M);
  private readonly fromAbove = new OrthographicCamera(-1, 1, 1, -1, 1, FAR_M);
  private grid = new GridHelper(1, 1);
  private drawing = false;
  private readonly keys = new Set<string>();    // Held.
  private readonly tapped = new Set<string>();  // Pressed since the last frame, held or not.

  constructor(readonly canvas: HTMLCanvasElement) {
    // Smooth edges would cost four times as much, and points have none.
    this.renderer = new WebGLRenderer({canvas, powerPreference: 'high-performance'});
    this.scene.add(this.overlay, new AmbientLight());
    for (const camera of [this.perspective, this.fromAbove]) camera.up.set(0, 0, 1);
    this.perspective.position.set(-20, -30, 30);
    this.controls = new OrbitControls(this.perspective, canvas);
    Object.assign(this.controls, {zoomToCursor: true, dampingFactor: 0.2, maxDistance: 8000});
    this.controls.maxPolarAngle = Math.PI * 0.99;
    this.controls.addEventListener('change', () => (this.onMove(), this.draw()));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.setGrid(200);
    this.resize();
  }

  get camera(): PerspectiveCamera | OrthographicCamera {
    return this.mode === 'top' ? this.fromAbove : this.perspective;
  }

  // Asks for a frame; any number of times before it comes.
  draw(): void {
    if (this.drawing) return;
    this.drawing = true;
    requestAnimationFrame(() => {
      this.drawing = false;
      this.walk();
      this.onFrame();
      this.setUniforms();
      this.renderer.render(this.scene, this.camera);
    });
  }

  setMode(mode: ViewMode): void {
    if (mode === this.mode) return;
    const {target} = this.controls;
    if (mode === 'top') {
      const heightM = this.perspective.position.distanceTo(target) *
          2 * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
      this.fromAbove.zoom = 1;
      this.mode = mode;
      this.setSpan(heightM);
    } else {
      const spanM = (this.fromAbove.top - this.fromAbove.bottom) / this.fromAbove.zoom;
      const away = spanM / (2 * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360));
      this.mode = mode;
      this.perspective.position.copy(target).add(
          new Vector3(-0.35, -0.6, 0.72).normalize().multiplyScalar(away));
    }
    this.useCamera();
  }

  // Looks at all of `bounds`.
  frame(bounds: Box): void {
    const box = new Box3(new Vector3().copy(bounds.min as Vector3),
                         new Vector3().copy(bounds.max as Vector3));
    const size = box.getSize(new Vector3());
    const radius = Math.max(size.length() / 2, 3);
    box.getCenter(this.controls.target);
    const {target} = this.controls;
    const away = radius / Math.sin((FIELD_OF_VIEW_DEG * Math.PI) / 360) /
        Math.min(1, Math.max(this.perspective.aspect, 0.5));
    const direction = new Vector3(-0.35, -0.6, 0.72).normalize();
    this.perspective.position.copy(target).addScaledVector(direction, 0.66 * away);
    if (this.mode === 'top') {
      this.fromAbove.zoom = 1;
      const aspect = this.perspective.aspect;
      this.setSpan(1.1 * Math.max(size.y, size.x / aspect, 4));
    }
    this.useCamera();
  }

  // Turns about `point` from now on.
  lookAt(point: Vector3): void {
    const shift = point.clone().sub(this.controls.target);
    this.controls.target.add(shift);
    this.camera.position.add(shift);
    this.controls.update();
    this.draw();
  }

  // Gives the pointer to the view (`free`), or to a tool.
  setDragging(free: boolean): void {
    this.controls.enabled = free;
  }

  key(code: string, down: boolean): void {
    if (down) {
      this.keys.add(code);
      this.tapped.add(code);
    } else {
      this.keys.delete(code);
    }
    this.draw();
  }

  releaseKeys(): void {
    this.keys.clear();
  }

  setBackground(background: string, lines: string): void {
    this.scene.background = new Color(background);
    const material = this.grid.material as unknown as {color: Color};
    material.color.set(lines);
    this.draw();
  }

  setGrid(sizeM: number): void {
    const step = sizeM > 2000 ? 100 : sizeM > 400 ? 50 : 10;
    const cells = Math.max(2, 2 * Math.ceil(sizeM / step / 2));
    const material = this.grid.material as unknown as {color: Color};
    const colour = material.color.clone();
    this.grid.removeFromParent();
    this.grid.dispose();
    this.grid = new GridHelper(cells * step, cells);
    this.grid.geometry.deleteAttribute('color');
    Object.assign(this.grid.material, {vertexColors: false, transparent: true, opacity: 0.5});
    (this.grid.material as unknown as {color: Color}).color.copy(colour);
    this.grid.rotation.x = Math.PI / 2;
    this.scene.add(this.grid);
  }

  setGridHeight(z: number, visible: boolean): void {
    this.grid.position.z = z;
    this.grid.visible = visible;
    this.draw();
  }

  eye(): Eye {
    const {camera} = this;
    camera.updateMatrixWorld();
    const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const frustum = new Frustum().setFromProjectionMatrix(matrix);
    const box = new Box3();
    const {x, y, z} = camera.position;
    return {
      pixelsPerMetre: this.pixelsPerMetre(),
      orthographic: this.mode === 'top',
      position: {x, y, z},
      sees: (bounds) => {
        box.min.copy(bounds.min as Vector3);
        box.max.copy(bounds.max as Vector3);
        return frustum.intersectsBox(box);
      },
    };
  }

  // CSS pixels.
  size(): {width: number; height: number} {
    return {width: this.canvas.clientWidth, height: this.canvas.clientHeight};
  }

  ray(x: number, y: number): Ray {
    const {width, height} = this.size();
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    return caster.ray;
  }

  // The point at which the ray through a pixel meets the height z; undefined if there is none.
  onHeight(x: number, y: number, z: number): Vector3 | undefined {
    return this.ray(x, y).intersectPlane(new Plane(new Vector3(0, 0, 1), -z), new Vector3()) ??
        undefined;
  }

  // Pixel of a point of the map; undefined behind the camera.
  project(point: Vector3): {x: number; y: number} | undefined {
    const at = point.clone().project(this.camera);
    if (at.z > 1 || at.z < -1) return undefined;
    const {width, height} = this.size();
    return {x: ((at.x + 1) / 2) * width, y: ((1 - at.y) / 2) * height};
  }

  // At a distance of one metre, or anywhere in the view from above.
  pixelsPerMetre(): number {
    const {height} = this.size();
    if (this.mode === 'top') {
      return (height * this.fromAbove.zoom) / (this.fromAbove.top - this.fromAbove.bottom);
    }
    return height / (2 * Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360));
  }

  private setSpan(heightM: number): void {
    const aspect = this.perspective.aspect;
    const half = heightM / 2;
    Object.assign(this.fromAbove,
                  {top: half, bottom: -half, left: -half * aspect, right: half * aspect});
  }

  private useCamera(): void {
    const {controls, camera} = this;
    controls.object = camera;
    const top = this.mode === 'top';
    if (top) {
      const {target} = controls;
      this.fromAbove.position.set(target.x, target.y - 1e-3, target.z + FAR_M / 2);
    }
    // From above, what is north stays up: the left button moves, nothing turns.
    controls.enableRotate = !top;
    controls.screenSpacePanning = top;
    controls.mouseButtons = top ?
        {LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN} :
        {LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN};
    controls.touches = {ONE: top ? TOUCH.PAN : TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN};
    camera.lookAt(controls.target);
    camera.updateProjectionMatrix();
    controls.update();
    this.onMove();
    this.draw();
  }

  private resize(): void {
    const box = this.canvas.parentElement!;
    const width = Math.max(box.clientWidth, 1);
    const height = Math.max(box.clientHeight, 1);
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.perspective.aspect = width / height;
    this.perspective.updateProjectionMatrix();
    this.setSpan(this.fromAbove.top - this.fromAbove.bottom);
    this.fromAbove.updateProjectionMatrix();
    this.onMove();
    this.draw();
  }

  private setUniforms(): void {
    this.uniforms.pixelsPerMetre.value = this.pixelsPerMetre() * this.renderer.getPixelRatio();
    this.uniforms.orthographic.value = this.mode === 'top';
  }

  // W A S D move over the ground, Q E down and up, as long as they are held, a step at least.
  private walk(): void {
    const moving = new Set([...this.keys, ...this.tapped]);
    this.tapped.clear();
    if (moving.size === 0) return;
    const {camera, controls} = this;
    const ahead = camera.getWorldDirection(new Vector3());
    if (this.mode === 'top') ahead.set(0, 1, 0);
    ahead.setZ(0).normalize();
    const right = new Vector3(ahead.y, -ahead.x, 0);
    const held = (code: string) => (moving.has(code) ? 1 : 0);
    const step = new Vector3()
        .addScaledVector(ahead, held('KeyW') - held('KeyS'))
        .addScaledVector(right, held('KeyD') - held('KeyA'))
        .add(new Vector3(0, 0, held('KeyE') - held('KeyQ')));
    const span = this.mode === 'top' ? this.size().height / this.pixelsPerMetre() :
                                       camera.position.distanceTo(controls.target);
    step.multiplyScalar(0.012 * Math.max(span, 2));
    camera.position.add(step);
    controls.target.add(step);
    controls.update();
    this.onMove();
    this.draw();
  }
}
