// While a control is being pressed, what the server says waits: a list that is made anew under the
// pointer, or between the pressing of a key and its release, would swallow the click.
const CONTROLS = 'button, select, input, a, label, summary, [role]:not(canvas)';
const LONGEST_MS = 3000;  // So long at most: whoever rests on a slider gets the news nevertheless.

let pressed: Promise<void> | undefined;

export function watchPresses(page: Window): void {
  const begin = (target: EventTarget | null) => {
    if (pressed || !(target instanceof Element) || !target.closest(CONTROLS)) return;
    pressed = new Promise((resolve) => {
      const end = () => {
        for (const event of ENDS) page.removeEventListener(event, later, true);
        clearTimeout(timer);
        pressed = undefined;
        resolve();
      };
      const later = (event: Event) => {
        // Elements lose the focus, too; it is the window's that counts.
        if (event.type !== 'blur' || event.target === page) setTimeout(end);  // After the click.
      };
      const timer = setTimeout(end, LONGEST_MS);
      for (const event of ENDS) page.addEventListener(event, later, true);
    });
  };
  page.addEventListener('pointerdown', (event) => begin(event.target), true);
  page.addEventListener('keydown', (event) => event.key === ' ' && begin(event.target), true);
}

const ENDS = ['pointerup', 'pointercancel', 'keyup', 'blur'];

// Resolves once nothing is pressed.
export async function released(): Promise<void> {
  await pressed;
}
