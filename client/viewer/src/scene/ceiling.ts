// The height of a ceiling that covers much of a map, which would hide from above all that is below.

const CELL_M = 1;        // The plan's cells, at least: walls take few of such cells.
const LARGEST_CELL_M = 8;
const POINTS = 8;        // In a cell, on average: coarse tiles want larger ones.
const FLAT_M = 0.3;      // A ceiling's points within a cell, noise of LiDARs and voxels included.
const BELOW = 0.6;       // Cell widths: air goes so far under a ceiling, not under a wall's top.
const CLEAR_M = 0.4;     // Above the highest sensor: where robots drove is no ceiling.
const SPREAD_M = 0.5;    // One ceiling's heights over the map: beams, and maps that bend a little.
const LOW = 0.1;         // Share of a ceiling's cells that may stay.
const MARGIN_M = 0.3;    // Cut so far below: lamps, noise.
const FEWEST_CELLS = 12;
// Share of the plan under it. By an OS1-64 in simulated worlds: warehouse 0.86, hotel 0.36, museum
// 0.32, house of two storeys 0.26; campus and forest 0.01.
const COVERED = 0.15;

// The cut's height, metres; undefined if there is no such ceiling. `points`: x, y, z of each, map
// frame; sensors drove no higher than `sensorZ`.
export function findCeiling(points: ArrayLike<number>, sensorZ: number): number | undefined {
  let cellM = CELL_M;
  let cells = cellsOf(points, cellM);
  while (points.length < 3 * POINTS * cells.size && cellM < LARGEST_CELL_M) {
    cells = cellsOf(points, cellM *= 2);
  }
  const lids: number[] = [];
  for (const heights of cells.values()) {
    const top = lidOf(heights, BELOW * cellM);
    if (top !== undefined && top > sensorZ + CLEAR_M) lids.push(top);
  }
  const ceiling = mostCommon(lids);
  if (ceiling.length < Math.max(FEWEST_CELLS, COVERED * cells.size)) return undefined;
  return Math.max(ceiling[Math.floor(LOW * ceiling.length)]! - MARGIN_M, sensorZ + CLEAR_M / 2);
}

// The heights of the points over each cell of the plan.
function cellsOf(points: ArrayLike<number>, cellM: number): Map<number, number[]> {
  const cells = new Map<number, number[]>();
  const far = 1 << 20;
  for (let i = 0; i + 2 < points.length; i += 3) {
    const x = Math.floor(points[i]! / cellM) + far;
    const key = x * 2 * far + Math.floor(points[i + 1]! / cellM) + far;
    const heights = cells.get(key);
    if (heights) heights.push(points[i + 2]!);
    else cells.set(key, [points[i + 2]!]);
  }
  return cells;
}

// The height of a cell's top where that is a level surface with nothing right under it.
function lidOf(heights: number[], belowM: number): number | undefined {
  const top = heights.reduce((a, b) => Math.max(a, b));
  const flat = heights.filter((z) => z > top - FLAT_M).length;
  const below = heights.filter((z) => z <= top - FLAT_M && z > top - FLAT_M - belowM).length;
  return flat >= 2 && below <= flat / 2 ? top : undefined;
}

// The largest group of heights within SPREAD_M, in order.
function mostCommon(heights: number[]): number[] {
  heights.sort((a, b) => a - b);
  let best = [0, 0];
  for (let from = 0, to = 0; to < heights.length; to++) {
    while (heights[to]! - heights[from]! > SPREAD_M) from++;
    if (to + 1 - from > best[1]! - best[0]!) best = [from, to + 1];
  }
  return heights.slice(best[0], best[1]);
}
