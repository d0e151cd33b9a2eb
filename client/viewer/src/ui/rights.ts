// Parts of the page that act on the server: where it would refuse the caller they lie still and say
// why. Who may call what is the server's to say: the page has no table of its own.
import type {RefusedMethod} from '../api/messages';
import {h} from './dom';

type Attributes = Parameters<typeof h>[1];
type Child = Node | string | undefined | false;

export class Rights {
  private refused = new Map<string, string>();

  // Why, by method ("DecideMatch"): of parts that were made already, and of those to come.
  take(refused: RefusedMethod[]): void {
    this.refused = new Map(refused.map(({method, why}) => [method, why]));
    document.querySelectorAll<HTMLFieldSetElement>('fieldset[data-method]')
        .forEach((part) => this.mark(part));
  }

  // A part of the page that calls that method of the server.
  part(method: string, attributes: Attributes, ...children: Child[]): HTMLFieldSetElement {
    const part = h('fieldset', {'data-method': method, ...attributes}, ...children);
    this.mark(part);
    return part;
  }

  private mark(part: HTMLFieldSetElement): void {
    const why = this.refused.get(part.dataset['method'] ?? '');
    part.disabled = why !== undefined;
    if (why === undefined) part.removeAttribute('title');
    else part.title = why;
  }
}
