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
    this.labels = new Labels(run, canvas);
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
    this.layers.get("Air").scale(this.painter.fit(this.canvas, isMoving) / seen);
    this.vehicles.update(t);
    for (const layer of this.layers.values()) if (layer.isShown) layer.update(t);
    this.painter.paint(this.scene, camera, this.canvas);
    this.labels.place(t, camera, pointed);
  }
}
