// Height curves of one run: drawn once, with a cursor at the time of the replay; dragging in them seeks.

import { PUSHING_AIR } from "./colours.js";

const PAD = { left: 60, right: 10, top: 8, bottom: 22 }; // [px], wide enough for "-0.05 m"
const REACH = 10; // distance from the pointer within which a curve is pointed at [px]
const SPAN_MARGIN = 0.06; // above and below the curves, of their span

/** Return lowest and highest height over all runs [m], so that all have one scale. */
export function heightsOf(runs) {
  const ranges = runs.flatMap((run) => [run.range("pos", 2), run.range("ref", 2)]);
  const low = Math.min(...ranges.map(([from]) => from));
  const high = Math.max(...ranges.map(([, to]) => to));
  const margin = Math.max((high - low) * SPAN_MARGIN, 0.05);
  return [low - margin, high + margin];
}

/** Heights over time in a canvas. */
export class HeightCurves {
  constructor(run, canvas, { heights, fullPush, duration, theme, onSeek }) {
    Object.assign(this, { run, canvas, heights, fullPush, duration, theme });
    this.backdrop = document.createElement("canvas");
    const seek = (event) => event.buttons && onSeek(this.#timeAt(event.offsetX));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener("pointermove", seek);
  }

  /** Draw in the colours of a page from now on. */
  colour(theme) {
    this.theme = theme;
    this.width = null; // drawn anew
  }

  /** Draw the curves with the cursor at time t [s]. */
  draw(t) {
    this.#fit();
    if (!this.width) return; // hidden
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.backdrop, 0, 0);
    pen.scale(this.pixels, this.pixels);
    this.#drawCursor(pen, t);
  }

  /** Return the vehicle whose curve is nearest to a point of the canvas [px]; null if none is near. */
  vehicleAt({ x, y }) {
    const t = this.#timeAt(x);
    const distances = this.run.names.map((_, vehicle) => Math.abs(this.#y(this.run.at("pos", vehicle, 2, t)) - y));
    const nearest = Math.min(...distances.filter((distance) => distance < REACH));
    return nearest < REACH ? distances.indexOf(nearest) : null;
  }

  #drawCursor(pen, t) {
    const x = this.#x(t);
    pen.strokeStyle = this.theme.ink;
    pen.lineWidth = 1;
    stroke(pen, [[x, PAD.top], [x, this.height - PAD.bottom]]);
    this.run.names.forEach((_, vehicle) => {
      const y = this.#y(this.run.at("pos", vehicle, 2, t));
      pen.fillStyle = this.run.colourOf(vehicle);
      pen.beginPath();
      pen.arc(x, y, 4, 0, 2 * Math.PI);
      if (!Number.isNaN(y)) pen.fill();
    });
  }

  /** Draw everything that does not move again when the canvas has another size. */
  #fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.width === width && this.height === height) return;
    this.pixels = Math.min(window.devicePixelRatio, 3);
    Object.assign(this, { width, height });
    for (const canvas of [this.canvas, this.backdrop]) {
      canvas.width = width * this.pixels;
      canvas.height = height * this.pixels;
    }
    const pen = this.backdrop.getContext("2d");
    pen.scale(this.pixels, this.pixels);
    this.#drawPushes(pen);
    this.#drawAxes(pen);
    this.#drawCurves(pen, "ref");
    this.#drawCurves(pen, "pos");
    this.#drawOutliers(pen);
  }

  /** Shade the times at which a vehicle is pushed. */
  #drawPushes(pen) {
    const right = this.width - PAD.right;
    pen.fillStyle = PUSHING_AIR;
    for (let x = PAD.left; x < right && this.run.has("downwash"); x++) {
      const pushes = this.run.names.map((_, vehicle) => this.run.push(vehicle, this.#timeAt(x)));
      pen.globalAlpha = 0.25 * Math.min(Math.max(...pushes) / this.fullPush, 1);
      pen.fillRect(x, PAD.top, 1, this.height - PAD.bottom - PAD.top);
    }
    pen.globalAlpha = 1;
  }

  #drawAxes(pen) {
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = this.theme.faint;
    pen.strokeStyle = this.theme.grid;
    pen.lineWidth = 1;
    pen.textAlign = "right";
    for (const z of ticksOf(this.heights, this.height / 45)) {
      const y = Math.round(this.#y(z)) + 0.5;
      stroke(pen, [[PAD.left, y], [this.width - PAD.right, y]]);
      pen.fillText(`${z} m`, PAD.left - 6, y + 4);
    }
    pen.textAlign = "center";
    const { since } = this.run.facts;
    for (const t of ticksOf([since, since + this.duration], this.width / 90)) {
      const half = pen.measureText(`${t} s`).width / 2;
      const x = Math.min(Math.max(this.#x(t - since), PAD.left + 8), this.width - half);
      pen.fillText(`${t} s`, x, this.height - 6);
    }
  }

  #drawCurves(pen, channel) {
    if (!this.run.has(channel)) return;
    const isReference = channel === "ref";
    pen.setLineDash(isReference ? [5, 4] : []);
    pen.lineWidth = isReference ? 1.2 : 1.8;
    this.run.names.forEach((_, vehicle) => {
      pen.strokeStyle = isReference ? this.theme.faint : this.run.colourOf(vehicle);
      stroke(pen, this.#points(this.run.series(channel, vehicle, 2)));
    });
    pen.setLineDash([]);
  }

  #drawOutliers(pen) {
    pen.strokeStyle = this.theme.ink;
    pen.lineWidth = 1.2;
    for (const [t, , , , z] of this.run.facts.outliers) {
      const [x, y] = [this.#x(t), Math.min(Math.max(this.#y(z), PAD.top), this.height - PAD.bottom)];
      stroke(pen, [[x - 3, y - 3], [x + 3, y + 3]]);
      stroke(pen, [[x - 3, y + 3], [x + 3, y - 3]]);
    }
  }

  /** Return the curve of a series, at most two points for each pixel. */
  #points(series) {
    const stride = Math.max(1, Math.floor(series.length / (2 * this.width)));
    const count = Math.ceil(series.length / stride);
    return Array.from({ length: count }, (_, at) => {
      const tick = at * stride;
      return [this.#x(tick / this.run.facts.rate), this.#y(series[tick])];
    });
  }

  #x(t) {
    return PAD.left + (t / this.duration) * (this.width - PAD.left - PAD.right);
  }

  #y(z) {
    const [low, high] = this.heights;
    return this.height - PAD.bottom - ((z - low) / (high - low)) * (this.height - PAD.top - PAD.bottom);
  }

  #timeAt(x) {
    const share = (x - PAD.left) / (this.width - PAD.left - PAD.right);
    return Math.min(Math.max(share, 0), 1) * this.duration;
  }
}

/** Return about `count` round numbers between two. */
function ticksOf([low, high], count) {
  const rough = (high - low) / Math.max(count, 2);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const first = Math.ceil(low / step);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, at) => Number(((first + at) * step).toPrecision(6)));
}

/** Draw a line through points; it breaks where one was not recorded. */
function stroke(pen, points) {
  pen.beginPath();
  let isBroken = true;
  for (const [x, y] of points) {
    if (Number.isNaN(y)) isBroken = true;
    else if (isBroken) {
      pen.moveTo(x, y);
      isBroken = false;
    } else pen.lineTo(x, y);
  }
  pen.stroke();
}
