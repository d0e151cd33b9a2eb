// The box that a person has drawn, the floor slice and the ceiling: what of the map is shown, or
// downloaded.
import {Vector3} from 'three';
import type {Box} from './api/geometry';
import {recall, remember, Signal} from './state';
import type {Uniforms} from './scene/point_material';

const FAR_M = 1e6;

export interface RegionState {
  box: Box | undefined;
  clip: boolean;    // Only what lies in the box is shown.
  slice: boolean;   // Only what lies in the slice is shown.
  sliceZ: number;   // Its floor, map frame.
  sliceM: number;   // Its height.
  // The height from which a ceiling hides the rest; undefined: there is none.
  ceilingZ: number | undefined;
  lid: boolean;     // A person wants to see the ceiling.
}

export class Region {
  readonly state = new Signal<RegionState>(
      {box: undefined, clip: false, slice: false, sliceZ: 0, sliceM: 2.5, ceilingZ: undefined,
       lid: recall('lid', '') === 'yes'});

  change(part: Partial<RegionState>): void {
    this.state.set({...this.state.value, ...part});
  }

  showLid(shown: boolean): void {
    remember('lid', shown ? 'yes' : 'no');
    this.change({lid: shown});
  }

  apply(uniforms: Uniforms): void {
    const bounds = visible(this.state.value);
    uniforms.clipOn.value = bounds !== undefined;
    if (!bounds) return;
    uniforms.clipMin.value.copy(bounds.min as Vector3);
    uniforms.clipMax.value.copy(bounds.max as Vector3);
  }
}

// True while the ceiling is cut.
export function isCut(state: RegionState): boolean {
  return state.ceilingZ !== undefined && !state.lid && !state.slice && !(state.clip && state.box);
}

// The box that is shown; undefined: everything.
export function visible(state: RegionState): Box | undefined {
  const cut = isCut(state);
  if (!cut && !state.slice && !(state.clip && state.box)) return undefined;
  const all = {min: {x: -FAR_M, y: -FAR_M, z: -FAR_M}, max: {x: FAR_M, y: FAR_M, z: FAR_M}};
  if (cut) return {min: all.min, max: {...all.max, z: state.ceilingZ!}};
  const box = state.clip && state.box ? state.box : all;
  if (!state.slice) return box;
  return {
    min: {...box.min, z: Math.max(box.min.z, state.sliceZ)},
    max: {...box.max, z: Math.min(box.max.z, state.sliceZ + state.sliceM)},
  };
}

// As the server wants a box of a download.
export function boxText({min, max}: Box): string {
  return [min.x, min.y, min.z, max.x, max.y, max.z].map((v) => v.toFixed(3)).join(',');
}
