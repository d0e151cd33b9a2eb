// Keys and the pointer on the map: to the tool that is active, else to the view.
import {Vector3} from 'three';
import type {App} from '../app';
import type {MarkSet} from '../scene/marks';
import type {Pointer} from '../tools/tool';
import {showHelp} from './dialogs';
import type {Shell} from './shell';

const CLICK_PX = 5;  // A pointer that moves less has clicked.
const WALK = ['KeyW', 'KeyA', 'KeyS', 'KeyD', 'KeyQ', 'KeyE'];

export function listen(app: App, shell: Shell): void {
  keys(app, shell);
  pointer(app);
}

function keys(app: App, shell: Shell): void {
  const marks = (set: MarkSet) => () => {
    app.marks.on[set] = !app.marks.on[set];
    const box = document.querySelector<HTMLInputElement>(`[data-set="${set}"] input`);
    if (box) box.checked = app.marks.on[set];
    app.remark();
  };
  const floor = (sign: number) => () => {
    const {slice, sliceZ, sliceM} = app.region.state.value;
    app.region.change({slice: true, sliceZ: slice ? sliceZ + sign * sliceM : sliceZ});
  };
  const clip = () => app.region.change({clip: !app.region.state.value.clip});
  const actions: Record<string, () => void> = {
    KeyF: () => app.showAll(), KeyT: () => shell.turnView(), KeyC: () => app.look.nextColour(),
    KeyM: () => shell.measure(), KeyB: () => shell.box(), KeyX: clip, KeyR: marks('robots'),
    KeyG: marks('graph'), KeyU: marks('submaps'), KeyL: () => shell.turnTheme(),
    KeyP: () => shell.fold(), PageUp: floor(1), PageDown: floor(-1),
    Escape: () => (app.use(undefined), app.match.set(undefined), app.submap.set(undefined),
                   app.loop.set(undefined)),
    ...Object.fromEntries(shell.tabs.map((tab, i) => [`Digit${i + 1}`, () => shell.show(tab)])),
  };
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || busy(event.target)) return;
    if (event.key === '?') return showHelp();
    if (app.tool.value?.key?.(event.code, event.shiftKey)) return event.preventDefault();
    if (WALK.includes(event.code)) return app.view.key(event.code, true);
    const action = actions[event.code];
    if (!action || (event.code.startsWith('Page') && scrolls(event.target))) return;
    event.preventDefault();
    action();
  });
  addEventListener('keyup', (event) => app.view.key(event.code, false));
  addEventListener('blur', () => app.view.releaseKeys());
}

// True if the keys are for a field or a dialog.
function busy(target: EventTarget | null): boolean {
  if (document.querySelector('dialog[open]')) return true;
  return target instanceof HTMLElement && target.matches(
      'input:not([type=checkbox]), select, textarea');
}

// True if the target is in the panel, which PageUp and PageDown scroll.
function scrolls(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest('aside') !== null;
}

function pointer(app: App): void {
  const {canvas} = app.view;
  let pressed: Pointer | undefined;
  let held = false;
  const at = (event: PointerEvent | MouseEvent): Pointer =>
      ({x: event.offsetX, y: event.offsetY, shift: event.shiftKey});
  app.tool.watch(() => (held = false, app.view.setDragging(true)));
  // Before the view's own controls hear of it.
  canvas.addEventListener('pointerdown', (event) => {
    pressed = at(event);
    const tool = app.tool.value;
    if (!tool?.drags || event.button !== 0 || !event.isPrimary) return;
    held = true;
    app.view.setDragging(false);
    canvas.setPointerCapture(event.pointerId);
    tool.down?.(pressed);
  }, {capture: true});
  canvas.addEventListener('pointermove', (event) => {
    if (held && event.isPrimary) app.tool.value?.drag?.(at(event));
  });
  const release = (event: PointerEvent) => {
    if (held && event.isPrimary) {
      held = false;
      app.tool.value?.up?.(at(event));
      app.view.setDragging(true);
    } else if (event.type === 'pointerup' && pressed && event.button === 0) {
      const now = at(event);
      if (Math.hypot(now.x - pressed.x, now.y - pressed.y) < CLICK_PX) app.tool.value?.click?.(now);
    }
    pressed = undefined;
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('dblclick', (event) => {
    if (app.tool.value) return;
    const picked = app.pick(at(event));
    if (picked) app.view.lookAt(new Vector3().copy(picked.at));
  });
}
