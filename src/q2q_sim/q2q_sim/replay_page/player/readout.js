// Height of each vehicle at the time of the replay, in the colour of its curve.

import { made } from "./controls.js";

const MOST = 8; // vehicles with a readout

/** Line with the heights of a run's vehicles. */
export class Readout {
  constructor(run) {
    this.run = run;
    this.values = run.names.slice(0, run.names.length <= MOST ? MOST : 0).map((name, vehicle) => {
      const value = made("span");
      value.style.setProperty("--colour", run.colourOf(vehicle));
      return value;
    });
    this.element = made("p", { className: "readout" }, this.values);
    if (run.names.length > MOST) this.element.textContent = `${run.names.length} vehicles`;
  }

  /** Show time t [s]. */
  draw(t) {
    this.values.forEach((value, vehicle) => {
      value.textContent = `${this.run.names[vehicle]} ${this.#words(vehicle, t)}`;
    });
  }

  #words(vehicle, t) {
    const z = this.run.at("pos", vehicle, 2, t);
    if (Number.isNaN(z)) return "not seen";
    const error = Math.round(100 * (z - this.run.at("ref", vehicle, 2, t)));
    const sign = error < 0 ? "−" : error > 0 ? "+" : "";
    const beside = Number.isNaN(error) ? "" : ` (${sign}${Math.abs(error)} cm)`;
    return `${z.toFixed(2).replace("-0.00", "0.00")} m${beside}`;
  }
}
