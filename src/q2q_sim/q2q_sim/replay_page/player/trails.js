// Trails: where each vehicle has been in the last seconds.

import { Color } from "three";
import { LineMaterial } from "./LineMaterial.js";
import { LineSegments2 } from "three/LineSegments2";
import { LineSegmentsGeometry } from "./LineSegmentsGeometry.js";
import { mixed } from "./colours.js";

const SPAN = 4; // [s]
const MOST_SEGMENTS = 200; // of all trails together
const MOST_STEPS = 40; // segments of a trail
const WIDTH = 3; // [px]

/** Fading trails of all vehicles of a run. */
export class Trails {
  constructor(run, room, theme) {
    this.run = run;
    this.steps = Math.min(Math.ceil(MOST_SEGMENTS / run.names.length), MOST_STEPS);
    this.shades = run.names.map((_, vehicle) => shadesOf(run.colourOf(vehicle), theme.room, this.steps));
    const numbers = () => new Float32Array(run.names.length * this.steps * 6); // two ends of three numbers
    const geometry = new LineSegmentsGeometry().setPositions(numbers()).setColors(numbers());
    this.ends = geometry.attributes.instanceStart.data;
    this.colours = geometry.attributes.instanceColorStart.data;
    this.lines = new LineSegments2(geometry, new LineMaterial({ linewidth: WIDTH, vertexColors: true }));
    this.lines.frustumCulled = false;
  }

  get objects() {
    return [this.lines];
  }

  /** Draw the seconds before time t [s]. */
  update(t) {
    let count = 0;
    for (let vehicle = 0; vehicle < this.run.names.length; vehicle++) {
      let newer = this.run.position(vehicle, t);
      for (let step = 0; step < this.steps; step++) {
        const before = t - ((step + 1) * SPAN) / this.steps;
        if (before < 0) break;
        const older = this.run.position(vehicle, before);
        if (!Number.isNaN(newer[0] + older[0])) this.#write(count++, [newer, older], this.shades[vehicle], step);
        newer = older;
      }
    }
    this.lines.geometry.instanceCount = count;
    this.ends.needsUpdate = this.colours.needsUpdate = true;
  }

  #write(segment, [newer, older], shades, step) {
    this.ends.array.set([...newer, ...older], 6 * segment);
    this.colours.array.set([...shades[step], ...shades[step + 1]], 6 * segment);
  }
}

/** Return the colours of a trail from its head to its end, which fades into the room. */
function shadesOf(colour, background, steps) {
  const share = (step) => 0.25 + 0.75 * (step / steps);
  return Array.from({ length: steps + 1 }, (_, step) => new Color(mixed(colour, background, share(step))).toArray());
}
