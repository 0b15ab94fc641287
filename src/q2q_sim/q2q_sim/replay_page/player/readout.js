// Heights of labelled vehicles at the time of the replay, in the colours of their curves; of many also that of the
// vehicle that is pointed at.

import { made } from "./controls.js";

/** Line with the heights of a run's vehicles. */
export class Readout {
  constructor(run) {
    this.run = run;
    this.values = run.labelled.map((vehicle) => this.#coloured(made("span"), vehicle));
    this.pointed = made("span", { className: "pointed" });
    const others = run.labelled.length < run.names.length ? [this.pointed] : [];
    this.element = made("p", { className: "readout" }, [...others, ...this.values]);
  }

  /** Show time t [s], and the vehicle that is pointed at, if any. */
  draw(t, pointed) {
    this.values.forEach((value, at) => (value.textContent = this.#words(this.run.labelled[at], t)));
    this.pointed.textContent = pointed === null ? `${this.run.names.length} vehicles: point at one` : this.#words(pointed, t);
    this.pointed.classList.toggle("none", pointed === null);
    if (pointed !== null) this.#coloured(this.pointed, pointed);
  }

  #coloured(value, vehicle) {
    value.style.setProperty("--colour", this.run.colourOf(vehicle));
    return value;
  }

  #words(vehicle, t) {
    return `${this.run.names[vehicle]} ${this.#height(vehicle, t)}`;
  }

  #height(vehicle, t) {
    const z = this.run.at("pos", vehicle, 2, t);
    if (Number.isNaN(z)) return "not seen";
    const error = Math.round(100 * (z - this.run.at("ref", vehicle, 2, t)));
    const sign = error < 0 ? "−" : error > 0 ? "+" : "";
    const beside = Number.isNaN(error) ? "" : ` (${sign}${Math.abs(error)} cm)`;
    return `${z.toFixed(2).replace("-0.00", "0.00")} m${beside}`;
  }
}
