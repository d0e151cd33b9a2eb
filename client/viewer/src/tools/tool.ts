// Tools take the pointer on the map while it is not turning or moving the view. One is active at a
// time; its card lies over the map.
export interface Pointer {
  x: number;  // CSS pixels in the canvas.
  y: number;
  shift: boolean;
}

export interface Tool {
  readonly name: string;
  readonly card: HTMLElement;
  // True if a drag is the tool's own, not the view's.
  readonly drags: boolean;
  click?(at: Pointer): void;
  down?(at: Pointer): void;
  drag?(at: Pointer): void;
  up?(at: Pointer): void;
  key?(code: string, shift: boolean): boolean;  // True if the key was the tool's.
  end(): void;
}

export interface ToolHost {
  // Ends what was active.
  use(tool: Tool | undefined): void;
}
