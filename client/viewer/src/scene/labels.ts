// Names at places of the map, as elements over it. Where they would lie on each other the ones that
// matter more are shown; the others come back as the view goes nearer.
import type {Vector3} from 'three';
import {h, swatch} from '../ui/dom';
import type {View} from './view';

// The more important comes first.
const ORDER = ['measure', 'robots', 'graph', 'anchors', 'submaps'];

interface Label {
  element: HTMLElement;
  at: Vector3;
  chosen: boolean;
  size: {width: number; height: number} | undefined;  // CSS pixels, once it was shown.
}

export interface Rectangle {x: number; y: number; width: number; height: number}

export class Labels {
  readonly element = h('div', {class: 'labels'});
  private readonly sets = new Map<string, Label[]>();

  constructor(private readonly view: View) {}

  // Replaces the labels of a set. With `onclick` a label is a button; a chosen one is always shown.
  set(name: string, labels: {
    text: string; at: Vector3; colour?: string; title?: string; chosen?: boolean;
    onclick?: () => void;
  }[]): void {
    for (const old of this.sets.get(name) ?? []) old.element.remove();
    this.sets.set(name, labels.map((label) => {
      const parts = [label.colour ? swatch(label.colour) : undefined, label.text];
      const element = label.onclick ?
          h('button', {type: 'button', class: 'label', title: label.title, onclick: label.onclick},
            ...parts) :
          h('span', {class: 'label', title: label.title}, ...parts);
      this.element.append(element);
      return {element, at: label.at, chosen: label.chosen ?? false, size: undefined};
    }));
    this.place();
  }

  // To be called with each frame.
  place(): void {
    const wanted = this.inView();
    for (const {label} of wanted) if (!label.size) label.element.hidden = false;
    for (const {label: {element}, label} of wanted) {
      label.size ??= {width: element.offsetWidth, height: element.offsetHeight};
    }
    const free = withoutOverlap(wanted.map(({label, pixel, away}) => ({
      x: pixel.x - label.size!.width / 2, y: pixel.y + (away / 100) * label.size!.height,
      ...label.size!,
    })));
    wanted.forEach(({label, pixel, away}, i) => {
      label.element.hidden = !free[i];
      if (!free[i]) return;
      label.element.style.transform =
          `translate(-50%, ${away}%) translate(${pixel.x.toFixed(1)}px, ${pixel.y.toFixed(1)}px)`;
    });
  }

  // The chosen ones first, then set by set, in each the nearest first. Hides all others.
  private inView() {
    const eye = this.view.camera.position;
    const found = [];
    for (const [name, labels] of this.sets) {
      // Below the line that they are of, where robots' names are not.
      const away = name === 'graph' ? 40 : -130;
      for (const label of labels) {
        const pixel = this.view.project(label.at);
        const rank = label.chosen ? -1 : ORDER.indexOf(name);
        if (pixel) found.push({label, pixel, away, rank, farM: eye.distanceTo(label.at)});
        else label.element.hidden = true;
      }
    }
    return found.sort((a, b) => a.rank - b.rank || a.farM - b.farM);
  }
}

// True for each that is shown; the first come first.
export function withoutOverlap(rectangles: Rectangle[]): boolean[] {
  const shown: Rectangle[] = [];
  return rectangles.map((one) => {
    const free = shown.every((other) =>
      one.x + one.width <= other.x || other.x + other.width <= one.x ||
      one.y + one.height <= other.y || other.y + other.height <= one.y);
    if (free) shown.push(one);
    return free;
  });
}
