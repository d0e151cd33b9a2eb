// Questions that stop everything else, and short messages that do not.
import {ASKING, button, die, h} from './dom';

function open(dialog: HTMLDialogElement): void {
  document.body.append(dialog);
  dialog.addEventListener('close', () => dialog.remove());
  dialog.showModal();
}

// The reason that a person gives; undefined if they cancel.
export function askNote(title: string, text: string, action: string): Promise<string | undefined> {
  return new Promise((resolve) => {
    const note = h('input', {type: 'text', maxlength: '1000', placeholder: 'Reason; stored with the decision'});
    let answer: string | undefined;
    const form = h(
        'form', {
          onsubmit: (event: SubmitEvent) => {
            event.preventDefault();
            answer = note.value.trim();
            dialog.close();
          },
        },
        h('h2', {}, title), h('p', {class: 'hint'}, text),
        h('label', {class: 'field'}, h('span', {}, 'Why (optional)'), note),
        h('div', {class: 'bar'}, button('Cancel', () => dialog.close()),
          h('button', {type: 'submit', class: 'main'}, action)));
    const dialog = h('dialog', {class: 'beside', 'aria-label': title}, form);
    dialog.addEventListener('close', () => resolve(answer));
    open(dialog);
    note.focus();
  });
}

// `why`: what is wrong with the one at hand, if there is more to say than that it does not hold;
// `check` throws what is wrong with a token.
export function askToken(why: string, check: (token: string) => Promise<void>): Promise<void> {
  return new Promise((resolve) => {
    const token = h('input', {
      type: 'password', autocomplete: 'current-password', required: true, 'aria-label': 'Token',
    });
    const wrong = h('p', {class: 'poor', role: 'alert'});
    const submit = h('button', {type: 'submit', class: 'main'}, 'Log in');
    const form = h(
        'form', {
          onsubmit: (event: SubmitEvent) => {
            event.preventDefault();
            die(submit, ASKING);
            wrong.textContent = '';
            check(token.value.trim())
                .then(() => dialog.close(), (error: Error) => (wrong.textContent = error.message))
                .finally(() => die(submit, undefined));
          },
        },
        h('h2', {}, 'This server asks for a token'),
        h('p', {class: 'hint'}, why || 'One that held before may have expired, or been revoked.'),
        h('label', {class: 'field'}, h('span', {}, 'Token'), token), wrong,
        h('p', {class: 'hint'}, 'Whoever runs the server makes one: ',
          h('code', {}, 'isthmus token create --role reader'),
          '. To decide about matches, anchors and revisions takes the role operator.'),
        h('div', {class: 'bar'}, submit));
    const dialog = h('dialog', {
      'aria-label': 'Access to this server', oncancel: (event: Event) => event.preventDefault(),
    }, form);
    dialog.addEventListener('close', () => resolve());
    open(dialog);
    token.focus();
  });
}

const KEYS: [string, string][] = [
  ['1 … 5', 'panel: map, robots, graph, history, events'],
  ['F', 'show all of the map'],
  ['T', 'from above, or orbit'],
  ['W A S D', 'move over the ground; Q E down and up'],
  ['C', 'next colouring'],
  ['M', 'measure'],
  ['B', 'draw a box: clip to it, download it'],
  ['X', 'clip to the box, or not'],
  ['PgUp PgDn', 'the floor slice up and down'],
  ['R  G  U', 'robots, match graph, submaps on or off'],
  ['L', 'dark or light'],
  ['P', 'fold the panel'],
  ['Esc', 'end the tool, clear the selection'],
];

const MOUSE: [string, string][] = [
  ['left drag', 'turn (from above: move)'],
  ['right drag', 'move'],
  ['wheel', 'nearer and farther, towards the pointer'],
  ['double click', 'turn about that point'],
  ['one finger', 'turn (from above: move); two: move and zoom'],
];

export function showHelp(): void {
  const table = (rows: [string, string][]) => h(
      'table', {}, ...rows.map(([key, text]) =>
        h('tr', {}, h('td', {}, h('kbd', {}, key)), h('td', {}, text))));
  const dialog = h(
      'dialog', {'aria-label': 'Help'}, h('h2', {}, 'Keys and pointer'), table(KEYS),
      h('h3', {}, 'Mouse and touch'), table(MOUSE),
      h('div', {class: 'bar'}, button('Close', () => dialog.close(), {class: 'main'})));
  open(dialog);
}

const TOAST_MS = 6000;

export class Toasts {
  readonly element = h('div', {class: 'toasts', role: 'status', 'aria-live': 'polite'});

  show(text: string, bad = false): void {
    for (const other of this.element.children) if (other.firstChild?.textContent === text) return;
    const toast = h('div', {class: bad ? 'toast poor' : 'toast'}, h('span', {}, text));
    toast.append(button('×', () => toast.remove(), {'aria-label': 'Dismiss', class: 'icon'}));
    this.element.append(toast);
    // An error stays until it is dismissed, or newer toasts push it out.
    if (!bad) setTimeout(() => toast.remove(), TOAST_MS);
    while (this.element.childElementCount > 4) this.element.firstChild?.remove();
  }
}
