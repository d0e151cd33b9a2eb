// The look of the points: what their colours say, how large they are, how many there may be.
import type {DataTexture} from 'three';
import {recall, remember, Signal} from '../state';
import type {TileLayer} from '../tiles/layer';
import type {RobotNumbers} from './colours';
import {COLOUR_BY, type ColourBy} from './point_material';
import type {View} from './view';

const SAMPLES_A_TILE = 400;
const OUTLIERS = 0.01;  // Share of the points at each end that the ramp leaves out.

export interface Range {min: number; max: number}

export class Look {
  readonly colourBy = new Signal<ColourBy>('height');
  // The values at the ramp's ends: metres, intensity, or milliseconds.
  readonly range = new Signal<Range>({min: 0, max: 1});
  ageS = 3600;
  budget: number;
  gapPx: number;
  readonly hiddenClasses = new Set<number>();
  private heights: Range = {min: 0, max: 3};
  private intensities: Range = {min: 0, max: 255};
  private stamps: Range = {min: 0, max: 1};

  constructor(private readonly view: View, private readonly numbers: RobotNumbers) {
    const saved = recall('colour', 'height') as ColourBy;
    this.colourBy.set(COLOUR_BY.includes(saved) ? saved : 'height');
    this.budget = Number(recall('budget', '4')) * 1e6;
    this.gapPx = Number(recall('gap', '2.5'));
    view.uniforms.pointPx.value = Number(recall('point', '2')) * view.renderer.getPixelRatio();
    this.apply();
  }

  setColour(by: ColourBy): void {
    remember('colour', by);
    this.colourBy.set(by);
    this.apply();
  }

  nextColour(): void {
    this.setColour(COLOUR_BY[(COLOUR_BY.indexOf(this.colourBy.value) + 1) % COLOUR_BY.length]!);
  }

  setPoint(px: number): void {
    remember('point', String(px));
    this.view.uniforms.pointPx.value = px * this.view.renderer.getPixelRatio();
    this.view.draw();
  }

  setBudget(millions: number): void {
    remember('budget', String(millions));
    this.budget = millions * 1e6;
    this.view.draw();
  }

  setGap(px: number): void {
    remember('gap', String(px));
    this.gapPx = px;
    this.view.draw();
  }

  setAge(seconds: number): void {
    this.ageS = seconds;
    this.apply();
  }

  hide(robots: Set<string>): void {
    const numbers = new Set([...robots].map((robot) => this.numbers.of(robot)));
    this.hideNumbers(this.view.uniforms.robots.value, numbers);
  }

  showClass(number: number, shown: boolean): void {
    if (shown) this.hiddenClasses.delete(number);
    else this.hiddenClasses.add(number);
    this.hideNumbers(this.view.uniforms.classes.value, this.hiddenClasses);
  }

  private hideNumbers(palette: DataTexture, numbers: Set<number>): void {
    const bytes = palette.image.data as Uint8Array;
    for (let i = 0; 4 * i < bytes.length; i++) bytes[4 * i + 3] = numbers.has(i) ? 0 : 255;
    palette.needsUpdate = true;
    this.view.draw();
  }

  // From what is shown, so that the ramp is spent on it.
  measure(layer: TileLayer): void {
    const {clipOn, clipMin, clipMax} = this.view.uniforms;
    const heights: number[] = [];
    const intensities: number[] = [];
    const stamps: number[] = [];
    for (const {points} of layer.visible()) {
      const step = Math.max(1, Math.floor(points.count / SAMPLES_A_TILE));
      for (let i = 0; i < points.count; i += step) {
        const z = points.origin[2] + points.scale[2] * points.positions[3 * i + 2]!;
        if (clipOn.value && (z < clipMin.value.z || z > clipMax.value.z)) continue;
        heights.push(z);
        intensities.push(points.intensities[i]!);
        if (points.stamps[i]! > 0) stamps.push(points.stamps[i]!);
      }
    }
    this.heights = ends(heights, this.heights, 0.5);
    this.intensities = ends(intensities, this.intensities, 1);
    this.stamps = ends(stamps, this.stamps, 1);
    this.view.setGridHeight(this.heights.min - 0.05, true);
    this.apply();
  }

  private apply(): void {
    const {uniforms} = this.view;
    const by = this.colourBy.value;
    uniforms.colourBy.value = COLOUR_BY.indexOf(by);
    const base = Math.floor(this.stamps.min);
    uniforms.timeBase.value = base;
    const now = Date.now() / 1000;
    let range = this.heights;
    if (by === 'intensity') range = this.intensities;
    if (by === 'time') range = {min: this.stamps.min - base, max: this.stamps.max - base};
    if (by === 'age') range = {min: now - this.ageS - base, max: now - base};
    uniforms.range.value.set(range.min, range.max);
    const shown = by === 'time' || by === 'age' ?
        {min: (range.min + base) * 1000, max: (range.max + base) * 1000} : range;
    this.range.set(shown);
    this.view.draw();
  }
}

function ends(values: number[], otherwise: Range, atLeast: number): Range {
  if (values.length === 0) return otherwise;
  values.sort((a, b) => a - b);
  const at = (share: number) => values[Math.round(share * (values.length - 1))]!;
  const min = at(OUTLIERS);
  return {min, max: Math.max(at(1 - OUTLIERS), min + atLeast)};
}
