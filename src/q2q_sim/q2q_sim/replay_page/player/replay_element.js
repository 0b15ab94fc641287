// The element <q2q-replay>: runs side by side, in step, with one camera and one time bar.

import { themeOf } from "./colours.js";
import { cameraChoice, group, isInSight, layerButtons, made, timeBar } from "./controls.js";
import { HeightCurves, heightsOf } from "./height_curves.js";
import { listenToKeys } from "./keys.js";
import { momentButtons } from "./moments.js";
import { Painter } from "./painter.js";
import { Playback } from "./playback.js";
import { tellPointed } from "./pointing.js";
import { Readout } from "./readout.js";
import { decodedRun } from "./recorded_run.js";
import { SharedCamera, roomOf } from "./room.js";
import { LAYERS, RunView } from "./run_view.js";

const MANY = 6; // vehicles above which zones and samples are hidden at first
const LONGEST_STEP = 0.1; // of the time between two pictures, as after the page was hidden [s]
const SLOW = 1 / 34; // time between two pictures above which fewer pixels are drawn [s]
const NO_WEBGL = "This browser shows no room in three dimensions (WebGL is off); the curves play.";
const JUDGED = 8; // pictures after which that is judged again

/** Define the element with its style. */
export function defineElement(style) {
  class ReplayElement extends HTMLElement {
    #replay = null;

    async connectedCallback() {
      if (this.shadowRoot) return;
      const root = this.attachShadow({ mode: "open" });
      const scripts = [...this.querySelectorAll("script[type='application/json']")];
      const runs = await Promise.all(scripts.map((script) => decodedRun(JSON.parse(script.textContent))));
      root.append(made("style", { textContent: style }));
      this.#replay = new Replay(this, root, runs);
    }

    /** Time [s], state and number of pictures, for the page that holds the element; null until it is ready. */
    get state() {
      if (!this.#replay) return null;
      const { playback, pictures } = this.#replay;
      return { t: playback.t, duration: playback.duration, isPlaying: playback.isPlaying, pictures };
    }

    play() {
      this.#replay.playback.play();
    }

    pause() {
      this.#replay.playback.pause();
    }

    seek(t) {
      this.#replay.playback.seek(t);
    }
  }
  customElements.define("q2q-replay", ReplayElement);
}

/** Replay of runs inside the root of an element. */
class Replay {
  pictures = 0;
  #isStale = true;
  #drawnAt = null;
  #paced = [];

  constructor(element, root, runs) {
    this.element = element;
    this.runs = runs;
    this.playback = new Playback(Math.max(...runs.map((run) => run.duration)), runs[0].facts.since);
    this.sight = new SharedCamera(roomOf(runs));
    this.sight.look("Room");
    this.panels = runs.map((run) => this.#panel(run));
    const rows = [timeBar(this.playback), group("options", this.#options())];
    root.append(group(runs.length > 1 ? "runs" : "runs single", this.panels.map(({ figure }) => figure)), ...rows, this.#notes());
    this.#enliven();
    this.#start();
  }

  #start() {
    this.playback.onChange(() => (this.#isStale = true));
    listenToKeys(this.element, this.playback);
    new ResizeObserver(() => (this.#isStale = true)).observe(this.element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#colour());
    requestAnimationFrame((now) => this.#frame(now));
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.playback.play();
  }

  /** Return figure and drawings of one run; the room is added once the figure has a size. */
  #panel(run) {
    const caption = made("figcaption", {}, [made("b", { textContent: run.facts.name }), ` ${run.facts.verdict}`]);
    const room = made("canvas", { className: "room", tabIndex: 0 });
    room.setAttribute("aria-label", `${run.facts.name}: vehicles in the room`);
    const curves = made("canvas", { className: "curves" });
    curves.setAttribute("aria-label", `${run.facts.name}: heights over time`);
    const readout = new Readout(run);
    const events = momentButtons(run.facts.events, this.playback);
    const figure = made("figure", {}, [caption, group("stage", [room]), readout.element, curves, events]);
    return { run, figure, room, curves, readout, pointed: null };
  }

  /** Add rooms and curves, in the colours of the page. */
  #enliven() {
    const theme = themeOf(this.element);
    const { fullPush } = this.sight.room;
    this.painter = painterOrNone();
    const shared = { heights: heightsOf(this.runs), fullPush, duration: this.playback.duration, theme };
    for (const panel of this.panels) {
      const onSeek = (t) => this.playback.seek(t);
      panel.heights = new HeightCurves(panel.run, panel.curves, { ...shared, onSeek });
      this.#tellPointed(panel, panel.curves, (point) => panel.heights.vehicleAt(point));
      this.#addRoom(panel, theme);
    }
  }

  /** Draw in the colours that the page has now. */
  #colour() {
    const theme = themeOf(this.element);
    for (const { view, heights } of this.panels) {
      view?.colour(theme);
      heights.colour(theme);
    }
    this.#isStale = true;
  }

  #addRoom(panel, theme) {
    if (!this.painter) {
      panel.room.replaceWith(made("p", { textContent: NO_WEBGL }));
      return;
    }
    panel.view = new RunView(panel.run, panel.room, { painter: this.painter, room: this.sight.room, theme });
    this.sight.attach(panel.room, () => (this.#isStale = true));
    const now = () => Math.min(this.playback.t, panel.run.duration);
    this.#tellPointed(panel, panel.room, (point) => panel.view.labels.vehicleAt(point, now(), this.sight.camera));
    for (const name of LAYERS.map((layer) => layer.name)) panel.view.show(name, this.#shown().has(name));
  }

  #tellPointed(panel, canvas, vehicleAt) {
    tellPointed(canvas, vehicleAt, (vehicle) => {
      if (panel.pointed === vehicle) return;
      panel.pointed = vehicle;
      this.#isStale = true;
    });
  }

  #shown() {
    const few = Math.max(...this.runs.map((run) => run.names.length)) <= MANY;
    return new Set(["Air", "Trails", ...(few ? ["Reference", "Zone", "Motion capture"] : [])]);
  }

  #options() {
    const cameras = cameraChoice(this.runs[0].names, {
      onLook: (name) => this.#moveCamera(() => this.sight.look(name)),
      onFollow: (vehicle) => this.#moveCamera(() => (this.sight.followed = vehicle)),
    });
    const known = LAYERS.filter(({ isIn }) => this.runs.some(isIn));
    const layers = layerButtons(known.map(({ name }) => name), this.#shown(), (name, isShown) => {
      for (const { view } of this.panels) view?.show(name, isShown);
      this.#isStale = true;
    });
    return [cameras, ...layers];
  }

  #moveCamera(move) {
    move();
    this.#isStale = true;
  }

  /** Return what the colours mean, and what was not recorded. */
  #notes() {
    const missing = this.runs.filter((run) => run.facts.missing.length > 0);
    const absent = missing.map((run) => `${run.facts.name}: no ${run.facts.missing.join(", no ")} recorded.`);
    const lines = new Set([...this.runs.map((run) => run.facts.note), ...absent]);
    const push = this.sight.room.fullPush.toPrecision(2);
    const legends = [
      [(run) => run.strongestPush() > 0, `Air turns from blue to orange as it pushes a vehicle below it (orange: ${push} m/s²).`],
      [(run) => run.has("ref"), "Dashed: reference."],
    ].flatMap(([isIn, words]) => (this.runs.some(isIn) ? [words] : []));
    const crosses = "Crosses: motion capture that the filter did not follow; in the curves at the edge if it lies outside.";
    if (this.runs.some((run) => run.facts.outliers.length > 0)) legends.push(crosses);
    return made("p", { className: "notes", textContent: [...legends, ...lines].join(" ") });
  }

  #frame(now) {
    requestAnimationFrame((next) => this.#frame(next));
    const seconds = this.#drawnAt === null ? 0 : Math.min((now - this.#drawnAt) / 1000, LONGEST_STEP);
    this.#drawnAt = now;
    if (!isInSight(this.element)) return;
    this.playback.advance(seconds);
    if (this.#isStale) this.#draw();
    if (this.playback.isPlaying) this.#keepPace(seconds);
  }

  /** Draw fewer pixels while pictures take long, as without a graphics card. */
  #keepPace(seconds) {
    this.#paced.push(seconds);
    if (this.#paced.length < JUDGED) return;
    const mean = this.#paced.reduce((sum, one) => sum + one, 0) / this.#paced.length;
    this.#paced = [];
    if (mean > SLOW) this.painter?.coarsen();
  }

  #draw() {
    this.#isStale = false;
    const { t } = this.playback;
    for (const { run, view, heights, readout, room, pointed } of this.panels) {
      const shown = Math.min(t, run.duration);
      heights.draw(shown);
      readout.draw(shown, pointed);
      if (!view) continue;
      this.sight.fit(room.clientWidth / room.clientHeight);
      this.#follow(run, shown);
      view.draw(shown, this.sight.camera, { isMoving: this.playback.isPlaying, pointed });
    }
    this.pictures += 1;
  }

  #follow(run, t) {
    if (this.sight.followed === null || run !== this.runs[0]) return;
    const point = run.position(this.sight.followed, t);
    if (!point.some(Number.isNaN)) this.sight.follow(point);
  }
}

function painterOrNone() {
  try {
    return new Painter();
  } catch {
    return null;
  }
}
