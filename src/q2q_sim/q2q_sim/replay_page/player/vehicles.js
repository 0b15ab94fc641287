// Quadcopters at their true size, and their shadows.

import {
  BoxGeometry,
  CircleGeometry,
  Color,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Quaternion,
  Vector3,
} from "three";

const THICKNESS = 0.13; // of an arm, over its length
const ROTOR = 0.5; // radius over the arm's length: the Crazyflie's 23 mm over 46 mm
const DIAGONALS = [1, 3, 5, 7].map((eighth) => (eighth * Math.PI) / 4);
const NOWHERE = new Matrix4().makeScale(0, 0, 0);

/** Instanced meshes of all vehicles of a run; an X configuration with x forward. */
export class Vehicles {
  constructor(run, room) {
    const { arm } = run.facts;
    const count = run.names.length;
    const disc = new CircleGeometry(1, 20);
    this.run = run;
    this.floor = room.floor;
    this.arms = coloured(new BoxGeometry(2 * arm, THICKNESS * arm, THICKNESS * arm), run, 2, 1);
    this.hubs = coloured(new BoxGeometry(0.7 * arm, 0.45 * arm, 0.3 * arm), run, 1, 1);
    this.rotors = coloured(disc, run, 4, 0.55);
    this.shadows = uniform(disc, count, "#000000", 0.22);
    this.rotors.material.side = 2;
    this.parts = this.#parts(arm);
  }

  get objects() {
    return [this.shadows, this.arms, this.hubs, this.rotors];
  }

  /** Move everything to time t [s]. */
  update(t) {
    for (let vehicle = 0; vehicle < this.run.names.length; vehicle++) {
      const pos = this.run.position(vehicle, t);
      const pose = posed(pos, this.run.orientation(vehicle, t));
      for (const { mesh, row, local } of this.parts(vehicle)) {
        mesh.setMatrixAt(row, pose ? pose.clone().multiply(local) : NOWHERE);
      }
      this.#putOnFloor(vehicle, pos);
    }
    for (const mesh of this.objects) mesh.instanceMatrix.needsUpdate = true;
  }

  #parts(arm) {
    const above = 0.2 * arm;
    const rotors = DIAGONALS.map((angle) => {
      const place = new Matrix4().makeTranslation(arm * Math.cos(angle), arm * Math.sin(angle), above);
      return place.scale(new Vector3(ROTOR * arm, ROTOR * arm, 1));
    });
    const arms = DIAGONALS.slice(0, 2).map((angle) => new Matrix4().makeRotationZ(angle));
    return (vehicle) => [
      { mesh: this.hubs, row: vehicle, local: new Matrix4() },
      ...arms.map((local, at) => ({ mesh: this.arms, row: 2 * vehicle + at, local })),
      ...rotors.map((local, at) => ({ mesh: this.rotors, row: 4 * vehicle + at, local })),
    ];
  }

  #putOnFloor(vehicle, [x, y, z]) {
    const size = 1.4 * this.run.facts.arm;
    const place = new Matrix4().makeTranslation(x, y, this.floor + 0.002).scale(new Vector3(size, size, 1));
    this.shadows.setMatrixAt(vehicle, Number.isNaN(z) ? NOWHERE : place);
  }
}

/** Return the transformation of a pose; null where it was not recorded. */
function posed(pos, quat) {
  if (pos.some(Number.isNaN)) return null;
  return new Matrix4().compose(new Vector3(...pos), new Quaternion(...quat), new Vector3(1, 1, 1));
}

/** Return `each` instances for every vehicle of a run, in the vehicle's colour. */
function coloured(geometry, run, each, opacity) {
  const count = run.names.length * each;
  const mesh = uniform(geometry, count, "#ffffff", opacity);
  for (let row = 0; row < count; row++) mesh.setColorAt(row, new Color(run.colourOf(Math.floor(row / each))));
  return mesh;
}

function uniform(geometry, count, color, opacity) {
  const isSolid = opacity === 1;
  const make = isSolid ? MeshLambertMaterial : MeshBasicMaterial;
  const material = new make({ color, opacity, transparent: true, depthWrite: isSolid });
  const mesh = new InstancedMesh(geometry, material, count);
  mesh.renderOrder = 1; // after the air, which would hide it
  mesh.frustumCulled = false; // its instances move
  return mesh;
}
