// Motion capture: the samples of the last second as dots, and the outliers of the last seconds as crosses.

import { BufferGeometry, CanvasTexture, Color, Float32BufferAttribute, Points, PointsMaterial } from "three";
import { mixed } from "./colours.js";

const SPAN = 1; // of samples [s]
const OUTLIER_SPAN = 2; // [s]
const MOST_OUTLIERS = 200;

/** Samples and outliers of all vehicles of a run. */
export class MocapSamples {
  constructor(run, room, theme) {
    this.run = run;
    this.each = Math.floor(SPAN * run.facts.rate);
    const colours = run.names.flatMap((_, vehicle) => {
      const colour = new Color(mixed(run.colourOf(vehicle), theme.ink, 0.5)).toArray();
      return Array(this.each).fill(colour).flat();
    });
    this.samples = pointsOf(run.names.length * this.each, { size: 2, vertexColors: true, transparent: true, opacity: 0.6 });
    this.samples.geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
    this.outliers = pointsOf(MOST_OUTLIERS, { size: 15, map: crossTexture(theme.ink), transparent: true, depthTest: false });
  }

  get objects() {
    return [this.samples, this.outliers];
  }

  /** Draw what was measured up to time t [s]. */
  update(t) {
    this.#drawSamples(t);
    const recent = this.run.facts.outliers.filter(([at]) => at <= t && at > t - OUTLIER_SPAN);
    recent.slice(-MOST_OUTLIERS).forEach(([, , ...pos], row) => put(this.outliers, row, pos));
    finish(this.outliers, Math.min(recent.length, MOST_OUTLIERS));
  }

  #drawSamples(t) {
    const last = Math.floor(t * this.run.facts.rate);
    for (let vehicle = 0; vehicle < this.run.names.length; vehicle++) {
      for (let back = 0; back < this.each; back++) {
        const pos = this.run.vector("mocap", vehicle, (last - back) / this.run.facts.rate);
        const known = last >= back && !Number.isNaN(pos[0]);
        put(this.samples, vehicle * this.each + back, known ? pos : [0, 0, -1e3]);
      }
    }
    finish(this.samples, this.samples.geometry.attributes.position.count);
  }
}

function pointsOf(count, options) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(new Float32Array(3 * count), 3));
  const points = new Points(geometry, new PointsMaterial({ sizeAttenuation: false, ...options }));
  points.frustumCulled = false;
  return points;
}

function put(points, row, pos) {
  points.geometry.attributes.position.setXYZ(row, ...pos);
}

function finish(points, count) {
  points.geometry.setDrawRange(0, count);
  points.geometry.attributes.position.needsUpdate = true;
}

function crossTexture(colour) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 32;
  const pen = canvas.getContext("2d");
  pen.strokeStyle = colour;
  pen.lineWidth = 6;
  pen.lineCap = "round";
  pen.stroke(new Path2D("M6 6L26 26M26 6L6 26"));
  return new CanvasTexture(canvas);
}
