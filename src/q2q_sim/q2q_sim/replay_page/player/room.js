// The room: its size from all flights, its floor, and views of it.

import { GridHelper, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/OrbitControls";

const FIELD_OF_VIEW = 38; // degrees
const MARGIN = 0.3; // around the flights, whose vehicles are wide [m]
const LEAST_FULL_PUSH = 0.2; // downwash that is drawn in full colour at least [m/s^2]
const VIEWS = {
  Room: { elevation: 16, azimuth: 22 },
  Side: { elevation: 0, azimuth: 0 },
  Top: { elevation: 89.9, azimuth: 0 },
}; // degrees; azimuth from the side that shows the longer horizontal extent

export const viewNames = Object.keys(VIEWS);

/** Return centre, size and radius [m] of what all runs fly through, from the floor up, and its strongest push. */
export function roomOf(runs) {
  const ranges = [0, 1, 2].map((axis) => {
    const each = runs.flatMap((run) => [run.range("pos", axis), run.range("ref", axis)]);
    const low = Math.min(...each.map(([from]) => from));
    const high = Math.max(...each.map(([, to]) => to));
    return [low - MARGIN, high + MARGIN];
  });
  ranges[2][0] = Math.min(0, ranges[2][0] + MARGIN);
  const size = ranges.map(([low, high]) => high - low);
  const centre = ranges.map(([low, high]) => (low + high) / 2);
  const fullPush = Math.max(LEAST_FULL_PUSH, ...runs.map((run) => run.strongestPush()));
  return { centre, size, floor: ranges[2][0], radius: Math.hypot(...size) / 2, fullPush };
}

/** Return the floor, with a grid of round metres. */
export function floorOf(room, theme) {
  const cell = cellOf(room);
  const cells = 2 * Math.ceil(Math.max(room.size[0], room.size[1]) / 2 / cell) + 2;
  const grid = new GridHelper(cells * cell, cells, theme.grid, theme.grid);
  grid.rotation.x = Math.PI / 2; // the library's floor is xz
  const [x, y] = room.centre.map((value) => Math.round(value / cell) * cell);
  grid.position.set(x, y, room.floor);
  return grid;
}

/** Return the side of a floor cell [m]. */
export function cellOf(room) {
  return room.radius < 2.5 ? 0.5 : room.radius < 12 ? 1 : 5;
}

/** Camera that all runs are seen by, moved from the canvas of any. */
export class SharedCamera {
  constructor(room) {
    this.room = room;
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, room.radius / 50, room.radius * 50);
    this.camera.up.set(0, 0, 1);
    this.target = new Vector3();
    this.view = viewNames[0];
    this.followed = null;
  }

  /** Move the camera by mouse and fingers on a canvas; `onMove` is called when it has moved. */
  attach(canvas, onMove) {
    canvas.addEventListener("wheel", (event) => keepForPage(event, canvas), { capture: true, passive: true });
    const controls = new OrbitControls(this.camera, canvas);
    controls.target = this.target;
    controls.minDistance = 0.3;
    controls.maxDistance = this.room.radius * 10;
    controls.addEventListener("start", () => (this.view = null));
    controls.addEventListener("change", onMove);
  }

  /** Look at the whole room from a named side. */
  look(name) {
    this.view = name;
    this.followed = null;
    const { elevation, azimuth } = VIEWS[name];
    const [up, around] = [elevation, azimuth].map((degrees) => (degrees * Math.PI) / 180);
    const along = this.room.size[0] >= this.room.size[1] ? -Math.PI / 2 : 0;
    const side = new Vector3(Math.cos(along + around), Math.sin(along + around), 0);
    const direction = side.multiplyScalar(Math.cos(up)).setZ(Math.sin(up));
    this.target.set(...this.room.centre);
    this.camera.position.copy(this.target).addScaledVector(direction, this.#distance(direction));
    this.camera.lookAt(this.target);
  }

  /** Move with a point, keeping direction and distance. */
  follow(point) {
    const step = new Vector3(...point).sub(this.target);
    this.target.add(step);
    this.camera.position.add(step);
  }

  /** Fit a canvas of this width over height; a followed vehicle stays followed. */
  fit(aspect) {
    if (this.camera.aspect === aspect) return;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (this.view && this.followed === null) this.look(this.view);
  }

  /** Return the distance at which the room's box fits the canvas, seen along a direction. */
  #distance(direction) {
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const right = new Vector3(0, 0, 1).cross(direction).normalize();
    const upward = direction.clone().cross(right);
    const reaches = cornersOf(this.room.size).map((corner) => {
      const aside = Math.max(Math.abs(corner.dot(upward)), Math.abs(corner.dot(right)) / this.camera.aspect);
      return corner.dot(direction) + aside / half; // nearer corners look larger
    });
    return Math.max(...reaches);
  }
}

/** Return the corners of a box around the origin. */
function cornersOf([x, y, z]) {
  const signs = [-0.5, 0.5];
  return signs.flatMap((a) => signs.flatMap((b) => signs.map((c) => new Vector3(a * x, b * y, c * z))));
}

/** Leave the wheel to the page until the canvas is clicked. */
function keepForPage(event, canvas) {
  if (canvas.getRootNode().activeElement !== canvas) event.stopImmediatePropagation();
}
