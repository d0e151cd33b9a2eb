// The material of points: size, colour, what is clipped, which robots are hidden.
import {
  DataTexture, GLSL3, NearestFilter, NoColorSpace, RGBAFormat, ShaderMaterial, Vector2, Vector3,
} from 'three';
import {CLASSES, hexBytes, rampBytes, robotColour} from './colours';

export const COLOUR_BY = ['height', 'intensity', 'robot', 'time', 'age', 'class'] as const;
export type ColourBy = (typeof COLOUR_BY)[number];

// Stamps are compared with this second, as a float does not hold seconds since 1970 exactly.
export interface Uniforms {
  colourBy: {value: number};
  range: {value: Vector2};  // The values at the ramp's ends: metres, intensity or seconds.
  timeBase: {value: number};
  clipMin: {value: Vector3};
  clipMax: {value: Vector3};
  clipOn: {value: boolean};
  pointPx: {value: number};
  pixelsPerMetre: {value: number};
  orthographic: {value: boolean};
  robots: {value: DataTexture};
  classes: {value: DataTexture};
  ramp: {value: DataTexture};
}

// The uniforms that all layers share; layers add `tint`, `only` and `hidden`, tiles the rest.
export function makeUniforms(): Uniforms {
  const ramp = new DataTexture(rampBytes(256), 256, 1, RGBAFormat);
  ramp.colorSpace = NoColorSpace;
  ramp.needsUpdate = true;
  return {
    colourBy: {value: 0},
    range: {value: new Vector2(0, 1)},
    timeBase: {value: 0},
    clipMin: {value: new Vector3()},
    clipMax: {value: new Vector3()},
    clipOn: {value: false},
    pointPx: {value: 2},
    pixelsPerMetre: {value: 1000},
    orthographic: {value: false},
    robots: {value: paletteOf(Array.from({length: 256}, (_, i) => robotColour(i)))},
    classes: {value: paletteOf(CLASSES.map(([, colour]) => colour))},
    ramp: {value: ramp},
  };
}

// A colour for each number; where its alpha is 0, that number's points are hidden.
function paletteOf(colours: string[]): DataTexture {
  const bytes = new Uint8Array(colours.length * 4);
  colours.forEach((colour, i) => bytes.set([...hexBytes(colour), 255], 4 * i));
  const texture = new DataTexture(bytes, colours.length, 1, RGBAFormat);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

const VERTEX = `
  in vec3 stored;
  in uint intensity;
  in uint robot;
  in uint stamp;
  in uint label;
  uniform int colourBy;
  uniform vec2 range;
  uniform uint timeBase;
  uniform vec3 clipMin;
  uniform vec3 clipMax;
  uniform bool clipOn;
  uniform float pointPx;
  uniform float pixelsPerMetre;
  uniform bool orthographic;
  uniform float gapM;
  uniform int only;
  uniform int hidden;
  uniform vec4 tint;
  uniform mat4 mapFromTile;
  uniform sampler2D robots;
  uniform sampler2D classes;
  uniform sampler2D ramp;
  out vec3 colour;

  float value(float height) {
    if (colourBy == 0) return height;
    if (colourBy == 1) return float(intensity);
    // Both differences are small enough to be exact.
    return stamp >= timeBase ? float(stamp - timeBase) : -float(timeBase - stamp);
  }

  void main() {
    vec4 at = mapFromTile * vec4(stored, 1.0);
    vec4 own = texelFetch(robots, ivec2(int(robot), 0), 0);
    vec4 kind = texelFetch(classes, ivec2(int(label), 0), 0);
    bool out_of_box = clipOn && (any(lessThan(at.xyz, clipMin)) || any(greaterThan(at.xyz, clipMax)));
    bool others = own.a < 0.5 || (only >= 0 && int(robot) != only) || int(robot) == hidden;
    if (out_of_box || others || kind.a < 0.5) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
      gl_PointSize = 0.0;
      return;
    }
    if (colourBy == 2 || colourBy == 5) {
      // A little light from above, so that walls and floors of one colour can be told apart.
      float h = clamp((at.z - range.x) / max(range.y - range.x, 0.01), 0.0, 1.0);
      colour = (colourBy == 2 ? own.rgb : kind.rgb) * (0.62 + 0.38 * h);
    } else if (colourBy >= 3 && stamp == 0u) {
      colour = vec3(0.5);
    } else {
      float t = clamp((value(at.z) - range.x) / max(range.y - range.x, 1e-6), 0.0, 1.0);
      colour = texture(ramp, vec2(t * 0.996 + 0.002, 0.5)).rgb;
    }
    colour = mix(colour, tint.rgb, tint.a);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(stored, 1.0);
    float metre = orthographic ? pixelsPerMetre : pixelsPerMetre / max(gl_Position.w, 0.05);
    gl_PointSize = clamp(gapM * metre, pointPx, 5.0 * pointPx);
  }`;

const FRAGMENT = `
  in vec3 colour;
  out vec4 result;
  void main() { result = vec4(colour, 1.0); }`;

export function makePointMaterial(shared: Uniforms, own: Record<string, {value: unknown}>):
    ShaderMaterial {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {...shared, ...own},
  });
}
