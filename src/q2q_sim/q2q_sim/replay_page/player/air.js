// Downwash as coloured air: soft puffs along the air that has left the rotors, and an arrow on who is pushed.
//
//   air that left at t - tau lies at r(t - tau) - b(t - tau) w tau      b body z, w the speed of the wake
//
// Without a speed it acts at once, straight below. A puff is as opaque as its rotors thrust; it turns from blue
// to orange by the push that is recorded on the vehicles in this air, full orange at the strongest push of the
// page. A recorded push comes from the air that passes nearest, and from any other within AIR_RADIUS. The
// puffs' own motion along the air is slowed down: the air itself passes in a tenth of a second.

import { ArrowHelper, BufferGeometry, Color, DynamicDrawUsage, Float32BufferAttribute } from "three";
import { Points, Quaternion, ShaderMaterial, Vector3 } from "three";
import { CALM_AIR, PUSHING_AIR } from "./colours.js";

const MOST_PUFFS = 200; // of all vehicles together
const PUFFS = [10, 22]; // of each vehicle, at least and at most
const PUFF_SPEED = 0.9; // at which puffs move [m/s]
const SPREAD = 0.12; // growth of the radius over the length of the air
const WIDEST_GAP = 1.3; // radius of a puff over the distance to the next, at least
const FADE = 0.55; // length over which the air fades to 1/e [m]
const OPACITY = 13; // of all puffs of a vehicle together
const AIR_RADIUS = 0.2; // distance from the air within which a vehicle is in it [m]
const NEAREST = 0.6; // distance within which the nearest air pushes a vehicle: air that lags and bends is drawn beside it [m]
const ARROW = 0.3; // length of an arrow for 1 m/s^2 [m]
const ARROW_SHOWN = 0.1; // smallest push with an arrow [m/s^2]

const VERTEX = `
  attribute float radius;
  attribute vec4 tint;
  uniform float pixels;
  varying vec4 shade;
  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * place;
    gl_PointSize = 2.0 * radius * pixels / -place.z;
    shade = tint;
  }`;
const FRAGMENT = `
  varying vec4 shade;
  void main() {
    float off = length(gl_PointCoord - 0.5) * 2.0;
    float soft = smoothstep(1.0, 0.0, off);
    gl_FragColor = vec4(shade.rgb, shade.a * soft * soft);
    #include <colorspace_fragment>
  }`;

/** Air below all vehicles of a run. */
export class Air {
  constructor(run, room, theme) {
    this.run = run;
    this.each = Math.min(Math.max(Math.floor(MOST_PUFFS / run.names.length), PUFFS[0]), PUFFS[1]);
    this.floor = room.floor;
    this.fullPush = room.fullPush;
    this.length = run.facts.zone.d;
    this.calm = new Color(CALM_AIR);
    this.pushing = new Color(PUSHING_AIR);
    this.puffs = new Points(puffGeometry(run.names.length * this.each), puffMaterial());
    this.puffs.frustumCulled = false;
    this.arrows = run.names.map(() => new ArrowHelper(new Vector3(0, 0, -1), new Vector3(), 1, PUSHING_AIR));
  }

  get objects() {
    return [this.puffs, ...this.arrows];
  }

  /** Set the height of the canvas [px] over the height seen at a distance of 1 m. */
  scale(pixels) {
    this.puffs.material.uniforms.pixels.value = pixels;
  }

  /** Move the air to time t [s]. */
  update(t) {
    const pushes = this.run.names.map((_, vehicle) => this.run.push(vehicle, t));
    const strongest = this.#strongestIn(t, pushes);
    for (let vehicle = 0; vehicle < this.run.names.length; vehicle++) {
      this.#blow(vehicle, t, Math.min(strongest[vehicle] / this.fullPush, 1));
      this.#point(vehicle, t, pushes[vehicle]);
    }
    for (const name of ["position", "radius", "tint"]) this.puffs.geometry.attributes[name].needsUpdate = true;
  }

  /** Return position and fading of the air of a vehicle, `along` metres from its rotors. */
  #parcel(vehicle, t, along) {
    const { wakeSpeed } = this.run.facts;
    const left = wakeSpeed === null ? t : t - along / wakeSpeed;
    const down = wakeSpeed === null ? [0, 0, -1] : downOf(this.run.orientation(vehicle, left));
    return this.run.position(vehicle, left).map((value, axis) => value + along * down[axis]);
  }

  #blow(vehicle, t, heat) {
    const { position, radius, tint } = this.puffs.geometry.attributes;
    const thrust = this.run.has("thrust") ? this.run.at("thrust", vehicle, 0, t) || 0 : 1;
    const colour = this.calm.clone().lerp(this.pushing, Math.sqrt(heat));
    const phase = (((t * PUFF_SPEED) / this.length) * this.each) % 1;
    const opacity = ((OPACITY * (1 + heat)) / this.each) * Math.min(thrust, 2);
    for (let puff = 0; puff < this.each; puff++) {
      const along = ((puff + phase) / this.each) * this.length;
      const at = this.#parcel(vehicle, t, along);
      const row = vehicle * this.each + puff;
      const shown = at[2] > this.floor ? Math.exp(-along / FADE) * (1 - along / this.length) : 0;
      position.setXYZ(row, ...(shown > 0 ? at : [0, 0, this.floor]));
      radius.setX(row, Math.max(1.3 * this.run.facts.arm + SPREAD * along, (WIDEST_GAP * this.length) / this.each));
      tint.setXYZW(row, colour.r, colour.g, colour.b, Math.min(opacity * shown, 1));
    }
  }

  /** Return the largest push on a vehicle in the air of each [m/s^2]. */
  #strongestIn(t, pushes) {
    const strongest = pushes.map(() => 0);
    pushes.forEach((push, pushed) => {
      if (!(push > 0)) return;
      const offsets = pushes.map((_, source) => this.#offset(pushed, source, t));
      const reach = Math.max(Math.min(...offsets, NEAREST), AIR_RADIUS);
      offsets.forEach((offset, source) => {
        if (offset <= reach) strongest[source] = Math.max(strongest[source], push);
      });
    });
    return strongest;
  }

  /** Return the horizontal distance of a vehicle from the air of another [m]; infinite if that is not above. */
  #offset(pushed, source, t) {
    const [x, y, z] = this.run.position(pushed, t);
    const above = this.run.position(source, t)[2] - z;
    if (pushed === source || !(above > 0.03)) return Infinity;
    const [u, v] = this.#parcel(source, t, above);
    const offset = Math.hypot(x - u, y - v);
    return Number.isNaN(offset) ? Infinity : offset;
  }

  #point(vehicle, t, push) {
    const arrow = this.arrows[vehicle];
    arrow.visible = this.isShown && push > ARROW_SHOWN;
    if (!arrow.visible) return;
    arrow.position.set(...this.run.position(vehicle, t));
    arrow.setDirection(new Vector3(...this.run.vector("downwash", vehicle, t)).normalize());
    arrow.setLength(ARROW * push, 0.05, 0.03);
  }
}

function downOf([x, y, z, w]) {
  return new Vector3(0, 0, -1).applyQuaternion(new Quaternion(x, y, z, w)).toArray();
}

function puffGeometry(count) {
  const geometry = new BufferGeometry();
  const widths = { position: 3, radius: 1, tint: 4 };
  for (const [name, width] of Object.entries(widths)) {
    const attribute = new Float32BufferAttribute(new Float32Array(count * width), width);
    geometry.setAttribute(name, attribute.setUsage(DynamicDrawUsage));
  }
  return geometry;
}

function puffMaterial() {
  return new ShaderMaterial({
    uniforms: { pixels: { value: 1 } },
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
  });
}
