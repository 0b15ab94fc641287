// The zone I(eps, d) about each vehicle: the outline of a cylinder, in another colour while a vehicle is in it.

import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments } from "three";
import { PUSHING_AIR } from "./colours.js";

const SIDES = 32; // of a ring
const POSTS = 4; // lines between the rings

/** Return which vehicles at these positions have another in their zone. */
function entered(positions, { eps, d }) {
  const inside = ([x, y, z], [u, v, w]) => Math.hypot(x - u, y - v) < eps && Math.abs(z - w) < d;
  return positions.map((own, row) => positions.some((other, at) => at !== row && inside(own, other)));
}

/** Outlines of the zones of all vehicles of a run. */
export class Zones {
  constructor(run, room, theme) {
    const geometry = outline();
    this.run = run;
    this.floor = room.floor;
    this.clear = new LineBasicMaterial({ color: theme.faint, transparent: true, opacity: 0.4 });
    this.entered = new LineBasicMaterial({ color: PUSHING_AIR, transparent: true, opacity: 0.6 });
    this.objects = run.names.map(() => new LineSegments(geometry, this.clear));
  }

  /** Move the outlines to time t [s]; they end at the floor. */
  update(t) {
    const { zone } = this.run.facts;
    const positions = this.run.names.map((_, vehicle) => this.run.position(vehicle, t));
    entered(positions, zone).forEach((isEntered, vehicle) => {
      const [x, y, z] = positions[vehicle];
      const low = Math.max(z - zone.d, this.floor);
      const lines = this.objects[vehicle];
      lines.visible = !Number.isNaN(x + y + z);
      lines.material = isEntered ? this.entered : this.clear;
      lines.position.set(x, y, low);
      lines.scale.set(zone.eps, zone.eps, z + zone.d - low);
    });
  }
}

/** Return a cylinder of radius and height 1 as two rings and the lines between them. */
function outline() {
  const point = (side, count, z) => [Math.cos((2 * Math.PI * side) / count), Math.sin((2 * Math.PI * side) / count), z];
  const sides = Array.from({ length: SIDES }, (_, side) => side);
  const rings = [0, 1].flatMap((z) => sides.flatMap((side) => [point(side, SIDES, z), point(side + 1, SIDES, z)]));
  const posts = sides.slice(0, POSTS).flatMap((side) => [point(side, POSTS, 0), point(side, POSTS, 1)]);
  const geometry = new BufferGeometry();
  return geometry.setAttribute("position", new Float32BufferAttribute([...rings, ...posts].flat(), 3));
}
