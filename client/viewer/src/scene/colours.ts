// Colours: one a robot, and ramps for what is measured.

// Told apart on dark and on light ground, also by most who see colours otherwise.
const ROBOTS = [
  '#3b8eea', '#f0803c', '#2fb67c', '#d65db1', '#c9a227', '#8b7cf6', '#1fb6c9', '#e05263',
  '#7fae3a', '#b0794f', '#5b9bd5', '#f2a65a', '#5dc2a0', '#b38ad9', '#a8a23e', '#e58a9b',
];
export const MAX_ROBOTS = 255;  // A robot's number is a byte; 255: any further one.

export function robotColour(index: number): string {
  return ROBOTS[index % ROBOTS.length]!;
}

// Dark blue over green to yellow: brighter is more, also in grey.
const RAMP: [number, number, number][] = [
  [58, 48, 140], [54, 92, 178], [38, 140, 180], [44, 178, 148], [112, 206, 96], [196, 224, 66],
  [250, 230, 80],
];

export function rampBytes(size: number): Uint8Array {
  const bytes = new Uint8Array(4 * size);
  for (let i = 0; i < size; i++) {
    const at = (i / (size - 1)) * (RAMP.length - 1);
    const low = Math.min(Math.floor(at), RAMP.length - 2);
    for (let c = 0; c < 3; c++) {
      const from = RAMP[low]![c]!;
      bytes[4 * i + c] = Math.round(from + (RAMP[low + 1]![c]! - from) * (at - low));
    }
    bytes[4 * i + 3] = 255;
  }
  return bytes;
}

// Classes of points, by number, as the API's PointClass.
export const CLASSES: [name: string, colour: string][] = [
  ['Unknown', '#7c828c'], ['Ground', '#a8814f'], ['Ceiling', '#b9a7d6'], ['Wall', '#5b8fd0'],
  ['Pole', '#e0a030'], ['Vegetation', '#58a845'], ['Vehicle', '#d65db1'], ['Object', '#e0704a'],
  ['Structure', '#2fb6b0'], ['Person', '#e05263'],
];

export function hexBytes(hex: string): [number, number, number] {
  const value = parseInt(hex.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

// The robots' numbers, in the order in which they were first seen.
export class RobotNumbers {
  private readonly numbers = new Map<string, number>();

  of(robot: string): number {
    let number = this.numbers.get(robot);
    if (number === undefined) {
      number = Math.min(this.numbers.size, MAX_ROBOTS);
      this.numbers.set(robot, number);
    }
    return number;
  }

  colour(robot: string): string {
    return robotColour(this.of(robot));
  }
}
