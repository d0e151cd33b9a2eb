// Names at places of the map, as elements over it.
import type {Vector3} from 'three';
import {h, swatch} from '../ui/dom';
import type {View} from './view';

interface Label {
  element: HTMLElement;
  at: Vector3;
}

export class Labels {
  readonly element = h('div', {class: 'labels'});
  private readonly sets = new Map<string, Label[]>();

  constructor(private readonly view: View) {}

  // Replaces the labels of a set. With `onclick` a label is a button.
  set(name: string, labels: {
    text: string; at: Vector3; colour?: string; title?: string; onclick?: () => void;
  }[]): void {
    for (const old of this.sets.get(name) ?? []) old.element.remove();
    this.sets.set(name, labels.map((label) => {
      const parts = [label.colour ? swatch(label.colour) : undefined, label.text];
      const element = label.onclick ?
          h('button', {type: 'button', class: 'label', title: label.title, onclick: label.onclick},
            ...parts) :
          h('span', {class: 'label', title: label.title}, ...parts);
      this.element.append(element);
      return {element, at: label.at};
    }));
    this.place();
  }

  // To be called with each frame.
  place(): void {
    for (const [name, labels] of this.sets) {
      // Below the line that they are of, where robots' names are not.
      const away = name === 'graph' ? 40 : -130;
      for (const {element, at} of labels) {
        const pixel = this.view.project(at);
        element.hidden = !pixel;
        if (!pixel) continue;
        element.style.transform =
            `translate(-50%, ${away}%) ` +
            `translate(${pixel.x.toFixed(1)}px, ${pixel.y.toFixed(1)}px)`;
      }
    }
  }
}
