// Names over the vehicles in the room: those that the run has names for, and the one that is pointed at.

import { Vector3 } from "three";
import { made } from "./controls.js";
import { shortNames } from "./short_names.js";

const ABOVE = 0.07; // [m]
const REACH = 30; // distance from the pointer within which a vehicle is pointed at [px]

/** Labels over the canvas of a run. */
export class Labels {
  constructor(run, canvas) {
    this.run = run;
    this.canvas = canvas;
    this.labels = shortNames(run.names).map((textContent, vehicle) => {
      const label = made("span", { className: "label", textContent, hidden: true });
      label.style.setProperty("--colour", run.colourOf(vehicle));
      return label;
    });
    canvas.parentElement.append(...this.labels);
  }

  /** Place the labels at time t [s]; one that would cover another goes above it. */
  place(t, camera, pointed) {
    const shown = new Set([...this.run.labelled, pointed]);
    const placed = [];
    this.labels.forEach((label, vehicle) => {
      const place = shown.has(vehicle) ? this.#seenAt(vehicle, t, camera) : null;
      label.hidden = !place;
      if (place) placed.push(this.#put(label, place, placed));
    });
  }

  /** Return the vehicle nearest to a point of the canvas [px]; null if none is near. */
  vehicleAt(point, t, camera) {
    const distances = this.labels.map((_, vehicle) => {
      const [across, down] = this.#seenAt(vehicle, t, camera) ?? [NaN, NaN];
      return Math.hypot(across - point.x, down - point.y);
    });
    const nearest = Math.min(...distances.filter((distance) => distance < REACH));
    return nearest < REACH ? distances.indexOf(nearest) : null;
  }

  /** Return where a vehicle's label is seen [px], across and down; null if it is not. */
  #seenAt(vehicle, t, camera) {
    const [x, y, z] = this.run.position(vehicle, t);
    const { x: across, y: up, z: depth } = new Vector3(x, y, z + ABOVE).project(camera);
    const isSeen = !Number.isNaN(x) && depth <= 1;
    return isSeen ? [((across + 1) / 2) * this.canvas.clientWidth, ((1 - up) / 2) * this.canvas.clientHeight] : null;
  }

  /** Put a label on a point, above all that it would cover; return its place [px]. */
  #put(label, [across, down], placed) {
    const { offsetWidth: width, offsetHeight: height } = label;
    const left = Math.max(Math.min(across - width / 2, this.canvas.clientWidth - width), 0);
    const beside = placed.filter((other) => left < other.right && other.left < left + width);
    const covered = (bottom) => beside.find((other) => bottom > other.top && bottom - height < other.bottom);
    let bottom = down;
    for (let other = covered(bottom); other; other = covered(bottom)) bottom = other.top;
    label.style.transform = `translate(${left.toFixed(1)}px, ${(bottom - height).toFixed(1)}px)`;
    return { left, right: left + width, top: bottom - height, bottom };
  }
}
