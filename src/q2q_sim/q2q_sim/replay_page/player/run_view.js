// The room of one run: a canvas that shows it at any time, with the vehicles' names over it.

import { AmbientLight, DirectionalLight, Scene } from "three";
import { Air } from "./air.js";
import { Labels } from "./labels.js";
import { MocapSamples } from "./mocap_samples.js";
import { floorOf } from "./room.js";
import { References } from "./references.js";
import { Trails } from "./trails.js";
import { Vehicles } from "./vehicles.js";
import { Zones } from "./zones.js";

/** Layers in the order of their buttons: name, class, and whether a run has what they show. */
export const LAYERS = [
  { name: "Air", make: Air, isIn: (run) => !run.isStill },
  { name: "Trails", make: Trails, isIn: (run) => run.has("pos") },
  { name: "Reference", make: References, isIn: (run) => run.has("ref") },
  { name: "Zone", make: Zones, isIn: (run) => run.has("pos") },
  { name: "Motion capture", make: MocapSamples, isIn: (run) => run.has("mocap") },
];

/** View of a run in a canvas. */
export class RunView {
  constructor(run, canvas, { painter, room, theme }) {
    Object.assign(this, { run, canvas, painter, room });
    this.vehicles = new Vehicles(run, room);
    this.labels = new Labels(run, canvas);
    this.layers = new Map();
    this.colour(theme);
  }

  /** Build the scene in the colours of a page; layers that were shown are. */
  colour(theme) {
    const wasShown = new Map([...this.layers].map(([name, layer]) => [name, layer.isShown]));
    const sun = new DirectionalLight("#ffffff", 1.6);
    sun.position.set(1, -2, 4);
    this.scene = new Scene();
    this.scene.add(floorOf(this.room, theme), sun, new AmbientLight("#ffffff", 1.6), ...this.vehicles.objects);
    for (const { name, make } of LAYERS.filter(({ isIn }) => isIn(this.run))) {
      const layer = new make(this.run, this.room, theme);
      this.layers.set(name, layer);
      this.scene.add(...layer.objects);
      this.show(name, wasShown.get(name) ?? true);
    }
  }

  /** Show or hide a layer. */
  show(name, isShown) {
    const layer = this.layers.get(name);
    if (!layer) return;
    layer.isShown = isShown;
    for (const part of layer.objects) part.visible = isShown;
  }

  /** Draw time t [s] as a camera sees it, with the name of a vehicle that is pointed at. */
  draw(t, camera, { isMoving, pointed }) {
    const seen = 2 * Math.tan((camera.fov * Math.PI) / 360); // height of the picture at a distance of 1 m [m]
    const pixels = this.painter.fit(this.canvas, isMoving) / seen;
    this.layers.get("Air")?.scale(pixels);
    this.vehicles.update(t);
    for (const layer of this.layers.values()) if (layer.isShown) layer.update(t);
    this.painter.paint(this.scene, camera, this.canvas);
    this.labels.place(t, camera, pointed);
  }
}
