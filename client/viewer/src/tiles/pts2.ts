// PTS2, the points of a tile: a header, then positions (3 x u16, scaled), intensities, robots,
// stamps, classes. docs/viewer.md points to where the format is described.

const HEADER_BYTES = 56;
const MAGIC = 0x32535450;  // "PTS2", little endian.

export interface Points {
  count: number;
  origin: [number, number, number];  // Map frame, metres.
  scale: [number, number, number];   // position = origin + scale * stored.
  positions: Uint16Array;            // 3 a point.
  intensities: Uint8Array;
  robots: Uint8Array;  // Indices into the tile's robots; 255: the 256th and above.
  stamps: Uint32Array;  // Last seen, Unix seconds; 0: unknown.
  classes: Uint8Array;  // As CLASSES of scene/colours.ts.
}

// Views into `data` where the alignment allows. Throws where the bytes are no PTS2.
export function parsePts2(data: ArrayBuffer): Points {
  if (data.byteLength < HEADER_BYTES) throw new Error('tile: shorter than a header');
  const view = new DataView(data);
  if (view.getUint32(0, true) !== MAGIC) throw new Error('tile: not PTS2');
  const count = view.getUint32(4, true);
  const stampsAt = HEADER_BYTES + 8 * count;
  if (data.byteLength !== stampsAt + 5 * count) {
    throw new Error(`tile: ${data.byteLength} bytes for ${count} points`);
  }
  const vector = (at: number): [number, number, number] =>
      [view.getFloat64(at, true), view.getFloat64(at + 8, true), view.getFloat64(at + 16, true)];
  return {
    count,
    origin: vector(8),
    scale: vector(32),
    positions: new Uint16Array(data, HEADER_BYTES, 3 * count),
    intensities: new Uint8Array(data, HEADER_BYTES + 6 * count, count),
    robots: new Uint8Array(data, HEADER_BYTES + 7 * count, count),
    stamps: new Uint32Array(data, stampsAt, count),
    classes: new Uint8Array(data, stampsAt + 4 * count, count),
  };
}
