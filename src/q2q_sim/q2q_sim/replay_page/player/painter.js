// One WebGL context for all canvases of a replay: it draws a scene and copies the picture.

import { WebGLRenderer } from "three";

const MOST_PIXELS = 2; // of a picture for each of the page
const FEWEST_PIXELS = 0.5;
const OPTIONS = { alpha: true, antialias: false, depth: true, stencil: false };

/** Painter of scenes; without a graphics card, or where that is slow, it draws fewer pixels in motion. */
export class Painter {
  /** Throws where WebGL is off. */
  constructor() {
    const canvas = new OffscreenCanvas(1, 1);
    const fast = canvas.getContext("webgl2", { ...OPTIONS, antialias: true, failIfMajorPerformanceCaveat: true });
    const context = fast ?? canvas.getContext("webgl2", OPTIONS);
    if (!context) throw new Error("WebGL is off");
    this.renderer = new WebGLRenderer({ canvas, context });
    this.best = Math.min(window.devicePixelRatio, fast ? MOST_PIXELS : 1);
    this.moving = this.best;
  }

  /** Draw fewer pixels in motion from now on. */
  coarsen() {
    this.moving = Math.max(0.75 * this.moving, Math.min(FEWEST_PIXELS, this.best));
  }

  /** Set the size of the picture of a canvas; return its height in pixels. */
  fit(canvas, isMoving) {
    const pixels = isMoving ? this.moving : this.best;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.max(1, Math.round(size * pixels)));
    if (this.renderer.domElement.width !== width || this.renderer.domElement.height !== height) {
      this.renderer.setSize(width, height, false);
    }
    return height;
  }

  /** Draw a scene into a canvas that has been fitted. */
  paint(scene, camera, canvas) {
    this.renderer.render(scene, camera);
    const picture = this.renderer.domElement.transferToImageBitmap();
    canvas.getContext("bitmaprenderer").transferFromImageBitmap(picture);
  }
}
