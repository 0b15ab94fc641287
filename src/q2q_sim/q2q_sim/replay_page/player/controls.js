// Buttons, lists and time bar of a replay.

import { viewNames } from "./room.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
const PLAY = "M7 4l13 8-13 8z";
const PAUSE = "M6 4h4v16H6zM14 4h4v16h-4z";

/** Return the bar with play button, time bar, time and speed. */
export function timeBar(playback) {
  const play = button("", () => playback.toggle(), "play");
  const slider = made("input", { type: "range", min: 0, max: playback.duration, step: 0.01 });
  slider.setAttribute("aria-label", "time in seconds");
  slider.addEventListener("input", () => playback.seek(Number(slider.value)));
  const now = made("span");
  const end = made("span", { className: "end", textContent: ` / ${playback.words(playback.duration)}` });
  const time = made("output", { className: "time" }, [now, end, " s"]);
  const show = () => {
    slider.value = playback.t;
    now.textContent = playback.words(playback.t);
    setIcon(play, playback.isPlaying);
  };
  playback.onChange(show);
  show();
  const speeds = choice("speed", SPEEDS.map((speed) => [`× ${speed}`, speed]), 1);
  speeds.addEventListener("change", () => (playback.speed = Number(speeds.value)));
  return group("bar", [play, slider, time, speeds]);
}

function setIcon(play, isPlaying) {
  const icon = isPlaying ? PAUSE : PLAY;
  if (play.dataset.icon === icon) return;
  play.dataset.icon = icon;
  play.setAttribute("aria-label", isPlaying ? "pause" : "play");
  play.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${icon}"/></svg>`;
}

/** Return the choice of a camera: a side of the room, or a vehicle to follow. */
export function cameraChoice(names, { onLook, onFollow }) {
  const followed = names.map((name, vehicle) => [`follow ${name}`, vehicle]);
  const cameras = choice("camera", [...viewNames.map((name) => [name.toLowerCase(), name]), ...followed], viewNames[0]);
  cameras.addEventListener("change", () => {
    if (viewNames.includes(cameras.value)) onLook(cameras.value);
    else onFollow(Number(cameras.value));
  });
  return cameras;
}

/** Return buttons that show and hide layers; `shown` holds the names of those that are on. */
export function layerButtons(names, shown, onShow) {
  return names.map((name) => {
    const toggle = button(name, () => {
      const isShown = toggle.getAttribute("aria-pressed") !== "true";
      toggle.setAttribute("aria-pressed", isShown);
      onShow(name, isShown);
    });
    toggle.setAttribute("aria-pressed", shown.has(name));
    return toggle;
  });
}

/** Return whether a part of an element is in the window. */
export function isInSight(element) {
  const { top, bottom } = element.getBoundingClientRect();
  return bottom > 0 && top < window.innerHeight;
}

/** Return a new element with properties. */
export function made(tag, properties = {}, children = []) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

export function group(className, children) {
  return made("div", { className }, children);
}

export function button(text, onClick, className = "") {
  const element = made("button", { type: "button", className, textContent: text });
  element.addEventListener("click", onClick);
  return element;
}

function choice(name, options, chosen) {
  const select = made("select");
  select.setAttribute("aria-label", name);
  select.append(...options.map(([text, value]) => made("option", { textContent: text, value })));
  select.value = chosen;
  return select;
}
