// The room of one run: a canvas that shows it at any time, with the vehicles' names over it.

import { AmbientLight, DirectionalLight, Scene, Vector3 } from "three";
import { Air } from "./air.js";
import { MocapSamples } from "./mocap_samples.js";
import { floorOf } from "./room.js";
import { References } from "./references.js";
import { Trails } from "./trails.js";
import { Vehicles } from "./vehicles.js";
import { Zones } from "./zones.js";

const MOST_LABELS = 8;
const LABEL_ABOVE = 0.07; // [m]

/** Layers in the order of their buttons: name, class, and the channel that they need. */
export const LAYERS = [
  { name: "Air", make: Air, needs: "pos" },
  { name: "Trails", make: Trails, needs: "pos" },
  { name: "Reference", make: References, needs: "ref" },
  { name: "Zone", make: Zones, needs: "pos" },
  { name: "Motion capture", make: MocapSamples, needs: "mocap" },
];

/** View of a run in a canvas. */
export class RunView {
  constructor(run, canvas, { painter, room, theme }) {
    this.run = run;
    this.canvas = canvas;
    this.painter = painter;
    this.scene = new Scene();
    this.vehicles = new Vehicles(run, room);
    this.layers = new Map();
    for (const { name, make, needs } of LAYERS) {
      if (run.has(needs)) this.layers.set(name, new make(run, room, theme));
    }
    const sun = new DirectionalLight("#ffffff", 1.6);
    sun.position.set(1, -2, 4);
    this.scene.add(floorOf(room, theme), sun, new AmbientLight("#ffffff", 1.6), ...this.vehicles.objects);
    for (const layer of this.layers.values()) this.scene.add(...layer.objects);
    this.labels = run.names.length <= MOST_LABELS ? run.names.map((name, row) => this.#label(name, row)) : [];
  }

  /** Show or hide a layer. */
  show(name, isShown) {
    const layer = this.layers.get(name);
    if (!layer) return;
    layer.isShown = isShown;
    for (const part of layer.objects) part.visible = isShown;
  }

  /** Draw time t [s] as a camera sees it. */
  draw(t, camera, isMoving) {
    const seen = 2 * Math.tan((camera.fov * Math.PI) / 360); // height of the picture at a distance of 1 m [m]
    this.layers.get("Air").scale(this.painter.fit(this.canvas, isMoving) / seen);
    this.vehicles.update(t);
    for (const layer of this.layers.values()) if (layer.isShown) layer.update(t);
    this.painter.paint(this.scene, camera, this.canvas);
    this.#placeLabels(t, camera);
  }

  #label(name, row) {
    const label = document.createElement("span");
    label.className = "label";
    label.textContent = name;
    label.style.setProperty("--colour", this.run.colourOf(row));
    this.canvas.parentElement.append(label);
    return label;
  }

  #placeLabels(t, camera) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.labels.forEach((label, vehicle) => {
      const [x, y, z] = this.run.position(vehicle, t);
      const place = new Vector3(x, y, z + LABEL_ABOVE).project(camera);
      const across = ((place.x + 1) / 2) * width;
      const down = ((1 - place.y) / 2) * height;
      label.hidden = Number.isNaN(x) || place.z > 1;
      label.style.transform = `translate(${across.toFixed(1)}px, ${down.toFixed(1)}px) translate(-50%, -100%)`;
    });
  }
}
