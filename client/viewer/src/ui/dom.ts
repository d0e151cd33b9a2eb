// Making elements, and the few kinds of controls that the page has. Text is always set as text: what
// robots and people wrote is never taken for markup.

type Child = Node | string | undefined | false;
type Attributes = Record<string, string | boolean | ((event: never) => void) | undefined>;

// `on...` attributes are listeners; false and undefined leave one out.
export function h<K extends keyof HTMLElementTagNameMap>(
    tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === 'function') {
      element.addEventListener(key.slice(2), value as EventListener);
    } else if (value !== false && value !== undefined) {
      element.setAttribute(key, value === true ? '' : value);
    }
  }
  add(element, ...children);
  return element;
}

export function add(parent: Node, ...children: Child[]): void {
  for (const child of children) {
    if (child === undefined || child === false) continue;
    parent.appendChild(typeof child === 'string' ? document.createTextNode(child) : child);
  }
}

// Replaces the children. If an element within had the focus, the one in the same place gets it,
// unless that has another tag.
export function fill(parent: Element, ...children: Child[]): void {
  const focus = document.activeElement;
  const path = focus && parent.contains(focus) && focus !== parent ? pathTo(focus, parent) : [];
  parent.replaceChildren();
  add(parent, ...children);
  let now: Element | undefined = parent;
  for (const index of path) now = now?.children[index];
  if (path.length > 0 && now instanceof HTMLElement && now.tagName === focus?.tagName) {
    now.focus({preventScroll: true});
  }
}

// The places of an element and of those that it is in, from the parent on.
function pathTo(element: Element, parent: Element): number[] {
  const path: number[] = [];
  for (let at: Element | null = element; at && at !== parent; at = at.parentElement) {
    path.unshift([...(at.parentElement?.children ?? [])].indexOf(at));
  }
  return path;
}

type ButtonAttributes = Attributes & {disabled?: never; dead?: string | undefined};

// `dead`: why it cannot be pressed, if so.
export function button(label: string, onclick: () => void,
                       {dead, ...attributes}: ButtonAttributes = {}): HTMLButtonElement {
  const made = h('button', {type: 'button', onclick, ...attributes}, label);
  if (dead !== undefined) die(made, dead);
  return made;
}

// None lies still without saying why. Undefined: it can be pressed.
export function die(button: HTMLButtonElement, why: string | undefined): void {
  button.disabled = why !== undefined;
  if (why === undefined) button.removeAttribute('title');
  else button.title = why;
}

export const ASKING = 'The server is being asked.';

// One that is on or off.
export function toggle(label: string, on: boolean, onchange: (on: boolean) => void): {
  element: HTMLLabelElement; set: (on: boolean) => void;
} {
  const input = h('input', {type: 'checkbox', onchange: () => onchange(input.checked)});
  input.checked = on;
  return {element: h('label', {class: 'check'}, input, label), set: (to) => (input.checked = to)};
}

export function choice<T extends string>(
    label: string, options: readonly (readonly [T, string])[], value: T,
    onchange: (value: T) => void): {element: HTMLLabelElement; select: HTMLSelectElement} {
  const select = h('select', {'aria-label': label, onchange: () => onchange(select.value as T)});
  setOptions(select, options, value);
  return {element: h('label', {class: 'field'}, h('span', {}, label), select), select};
}

export function setOptions(
    select: HTMLSelectElement, options: readonly (readonly [string, string])[],
    value: string): void {
  fill(select, ...options.map(([key, text]) => h('option', {value: key}, text)));
  select.value = value;
}

export interface NumberField {
  element: HTMLLabelElement;
  get: () => number;
  set: (value: number) => void;
  input: HTMLInputElement;
}

export function number(label: string, value: number, step: number,
                       onchange: (value: number) => void = () => undefined): NumberField {
  const input = h('input', {
    type: 'number', step: 'any', 'aria-label': label, inputmode: 'decimal',
    onchange: () => onchange(get()),
    // The browser steps an "any" field by 1: here by what suits the quantity.
    onkeydown: (event: KeyboardEvent) => {
      const sign = event.key === 'ArrowUp' ? 1 : event.key === 'ArrowDown' ? -1 : 0;
      if (sign === 0) return;
      event.preventDefault();
      set(get() + sign * step);
      onchange(get());
    },
  });
  const get = () => (Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : 0);
  const set = (to: number) => (input.value = String(Math.round(to * 1000) / 1000));
  set(value);
  return {element: h('label', {class: 'field number'}, h('span', {}, label), input), get, set, input};
}

export interface Slider {
  element: HTMLLabelElement;
  input: HTMLInputElement;
  set: (value: number) => void;
}

export function slider(label: string, [min, max, step]: [number, number, number], value: number,
                       show: (value: number) => string, oninput: (value: number) => void): Slider {
  const output = h('output', {}, show(value));
  const input = h('input', {
    type: 'range', min: String(min), max: String(max), step: String(step), 'aria-label': label,
    oninput: () => {
      output.textContent = show(input.valueAsNumber);
      oninput(input.valueAsNumber);
    },
  });
  input.value = String(value);
  const set = (to: number) => {
    input.value = String(to);
    output.textContent = show(input.valueAsNumber);
  };
  return {element: h('label', {class: 'slider'}, h('span', {}, label), input, output), input, set};
}

export function section(title: string, ...children: Child[]): HTMLElement {
  return h('section', {'aria-label': title}, h('h3', {}, title), ...children);
}

export function hint(text: string): HTMLParagraphElement {
  return h('p', {class: 'hint'}, text);
}

export function swatch(colour: string): HTMLSpanElement {
  const element = h('span', {class: 'swatch', 'aria-hidden': 'true'});
  element.style.backgroundColor = colour;
  return element;
}

// A row of a list that can be chosen.
export function row(selected: boolean, onclick: () => void, ...children: Child[]): HTMLElement {
  return h('button', {
    type: 'button', class: 'row', 'aria-pressed': String(selected), onclick,
  }, ...children);
}
