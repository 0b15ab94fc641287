// Vehicle that is pointed at in the room or in the curves, by mouse or finger.

/** Tell which vehicle is pointed at in a canvas; `vehicleAt` returns that of a point [px], or null. */
export function tellPointed(canvas, vehicleAt, onPoint) {
  const look = ({ offsetX, offsetY }) => onPoint(vehicleAt({ x: offsetX, y: offsetY }));
  canvas.addEventListener("pointermove", look);
  canvas.addEventListener("pointerdown", look);
  canvas.addEventListener("pointerleave", ({ pointerType }) => {
    if (pointerType === "mouse") onPoint(null); // what a finger touched stays
  });
}
