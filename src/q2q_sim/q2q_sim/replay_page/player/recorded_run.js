// One run of the page's data: its quantities at any time since the start.

import { tinted } from "./colours.js";

const MISSING = 65535;
const LEVEL = [0, 0, 0, 1];
const MOST_LABELLED = 8; // vehicles whose names are shown all the time

/** Return the run of its JSON, with every quantity decoded (packed_run.py says how they are packed). */
export async function decodedRun(packed) {
  const channels = {};
  for (const [name, channel] of Object.entries(packed.channels)) {
    channels[name] = await decoded(channel, packed.names.length, packed.count);
  }
  return new RecordedRun(packed, channels);
}

async function decoded(channel, vehicles, count) {
  const planes = await inflated(channel.data);
  const series = vehicles * channel.width;
  const values = new Float32Array(series * count);
  for (let row = 0, at = 0; row < series; row++) {
    let code = 0;
    for (let tick = 0; tick < count; tick++, at++) {
      const zigzag = planes[at] | (planes[values.length + at] << 8);
      code = (code + ((zigzag >>> 1) ^ -(zigzag & 1))) & 0xffff;
      values[at] = code === MISSING ? NaN : channel.low + code * channel.step;
    }
  }
  return { width: channel.width, values };
}

async function inflated(base64) {
  const letters = atob(base64);
  const packed = new Uint8Array(letters.length);
  for (let at = 0; at < packed.length; at++) packed[at] = letters.charCodeAt(at);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Quantities of one run, by channel: pos, quat, ref, mocap, downwash, thrust. */
export class RecordedRun {
  #channels;

  constructor(facts, channels) {
    this.#channels = channels;
    this.facts = facts;
    this.names = facts.names;
    this.duration = (facts.count - 1) / facts.rate;
    this.labelled = labelledVehicles(facts);
  }

  colourOf(vehicle) {
    return tinted(this.facts.palette, vehicle);
  }

  has(channel) {
    return channel in this.#channels;
  }

  /** Return one component of a vehicle over all ticks. */
  series(channel, vehicle, component) {
    const { width, values } = this.#channels[channel];
    const start = (vehicle * width + component) * this.facts.count;
    return values.subarray(start, start + this.facts.count);
  }

  /** Return one component at time t [s], between ticks by interpolation; NaN where it was not recorded. */
  at(channel, vehicle, component, t) {
    if (!this.has(channel)) return NaN;
    const series = this.series(channel, vehicle, component);
    const place = this.#place(t);
    const tick = Math.floor(place);
    const share = place - tick;
    return share === 0 ? series[tick] : series[tick] + share * (series[tick + 1] - series[tick]);
  }

  /** Return time t [s] in ticks. */
  #place(t) {
    return Math.min(Math.max(t * this.facts.rate, 0), this.facts.count - 1);
  }

  /** Return the three components at time t [s]. */
  vector(channel, vehicle, t) {
    return [0, 1, 2].map((component) => this.at(channel, vehicle, component, t));
  }

  position(vehicle, t) {
    return this.vector("pos", vehicle, t);
  }

  /** Return the orientation x y z w at time t [s]; level where it was not recorded. */
  orientation(vehicle, t) {
    if (!this.has("quat")) return LEVEL;
    const place = this.#place(t);
    const [before, after] = [Math.floor(place), Math.ceil(place)].map((tick) => this.#quaternion(vehicle, tick));
    const share = place - Math.floor(place);
    const sign = before.reduce((sum, value, row) => sum + value * after[row], 0) < 0 ? -1 : 1; // the short way
    const mixed = before.map((value, row) => (1 - share) * value + sign * share * after[row]);
    const length = Math.hypot(...mixed);
    return Number.isNaN(length) ? LEVEL : mixed.map((value) => value / length);
  }

  /** Return the orientation at a tick, its w from the three that are kept. */
  #quaternion(vehicle, tick) {
    const [x, y, z] = [0, 1, 2].map((component) => this.series("quat", vehicle, component)[tick]);
    return [x, y, z, Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z))];
  }

  /** Return the size of the downwash on a vehicle at time t [m/s^2]; 0 where it was not recorded. */
  push(vehicle, t) {
    return Math.hypot(...this.vector("downwash", vehicle, t)) || 0;
  }

  /** Return the largest downwash on any vehicle at any tick [m/s^2]; 0 where none was recorded. */
  strongestPush() {
    let strongest = 0;
    for (let vehicle = 0; vehicle < this.names.length && this.has("downwash"); vehicle++) {
      const [x, y, z] = [0, 1, 2].map((component) => this.series("downwash", vehicle, component));
      for (let tick = 0; tick < this.facts.count; tick++) {
        const size = Math.hypot(x[tick], y[tick], z[tick]);
        if (size > strongest) strongest = size;
      }
    }
    return strongest;
  }

  /** Return whether the downwash was recorded, and no vehicle was ever in one. */
  get isStill() {
    return this.has("downwash") && this.strongestPush() === 0;
  }

  /** Return lowest and highest value of a component over all vehicles. */
  range(channel, component) {
    let low = Infinity;
    let high = -Infinity;
    for (let vehicle = 0; vehicle < this.names.length && this.has(channel); vehicle++) {
      for (const value of this.series(channel, vehicle, component)) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return [low, high];
  }
}

/** Return the vehicles whose names are shown all the time: all, or of many those that marked moments name first. */
function labelledVehicles({ names, events = [] }) {
  const rows = names.map((_, vehicle) => vehicle);
  if (rows.length <= MOST_LABELLED) return rows;
  const words = events.flatMap((event) => event.words.match(/[\w/-]+/g));
  const named = new Set(words.map((word) => names.indexOf(word)).filter((vehicle) => vehicle >= 0));
  return [...named].slice(0, MOST_LABELLED);
}
