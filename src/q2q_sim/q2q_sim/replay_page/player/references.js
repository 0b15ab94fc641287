// References: where each vehicle was to fly, as a dashed line, and its point now as a ball.

import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments } from "three";
import { Mesh, MeshBasicMaterial, SphereGeometry } from "three";

const STEP = 0.1; // length of a dash [s]
const BALL = 0.25; // radius over a vehicle's arm

/** Lines and balls of a run. */
export class References {
  constructor(run, room, theme) {
    const points = run.names.flatMap((_, vehicle) => dashesOf(run, vehicle));
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(points.flat(), 3));
    const look = { color: theme.faint, transparent: true, opacity: 0.65 };
    const ball = new SphereGeometry(BALL * run.facts.arm, 8, 6);
    const material = new MeshBasicMaterial(look);
    this.run = run;
    this.balls = run.names.map(() => new Mesh(ball, material));
    this.objects = [new LineSegments(geometry, new LineBasicMaterial(look)), ...this.balls];
  }

  /** Move the balls to time t [s]. */
  update(t) {
    this.balls.forEach((ball, vehicle) => {
      const point = this.run.vector("ref", vehicle, t);
      ball.visible = !point.some(Number.isNaN);
      ball.position.set(...point);
    });
  }
}

/** Return the ends of every second segment along a vehicle's reference. */
function dashesOf(run, vehicle) {
  const ends = [];
  for (let t = 0; t + STEP <= run.duration; t += 2 * STEP) {
    const dash = [run.vector("ref", vehicle, t), run.vector("ref", vehicle, t + STEP)];
    if (!dash.flat().some(Number.isNaN)) ends.push(...dash);
  }
  return ends;
}
