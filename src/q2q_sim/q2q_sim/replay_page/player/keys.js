// Keys of a replay: they play and step it, except where a control that was reached by keys needs them itself.

import { isInSight } from "./controls.js";

const STEP = 0.1; // of the arrow keys [s]
const LONG_STEP = 1; // with Shift [s]
const TYPED_IN = "input, select, textarea"; // need all keys
const PRESSED = "button, summary"; // need Space

/** Play, pause and step by keys while the element is in sight. */
export function listenToKeys(element, playback) {
  const keys = {
    " ": () => playback.toggle(),
    ArrowLeft: (step) => playback.seek(playback.t - step),
    ArrowRight: (step) => playback.seek(playback.t + step),
    Home: () => playback.seek(0),
    End: () => playback.seek(playback.duration),
  };
  document.addEventListener("keydown", (event) => {
    const isTaken = needs(event.composedPath()[0], event.key, element);
    if (!(event.key in keys) || isTaken || event.ctrlKey || event.metaKey || !isInSight(element)) return;
    event.preventDefault();
    keys[event.key](event.shiftKey ? LONG_STEP : STEP);
  });
  releasePointedFocus(element.shadowRoot);
}

/** Return whether a focused part of the page needs a key itself; the replay's own time bar needs none. */
function needs(focused, key, element) {
  const isTimeBar = element.shadowRoot.contains(focused) && focused.matches("input");
  if (isTimeBar || !focused.matches) return false;
  return focused.matches(key === " " ? `${TYPED_IN}, ${PRESSED}` : TYPED_IN);
}

/** Take the focus from a control that was used by mouse or finger; one that was reached by keys keeps it. */
function releasePointedFocus(root) {
  let isPointed = false;
  root.addEventListener("pointerdown", () => (isPointed = true));
  root.addEventListener("keydown", () => (isPointed = false));
  const release = ({ target }, kind) => isPointed && target.closest(kind)?.blur();
  root.addEventListener("click", (event) => release(event, "button"));
  root.addEventListener("change", (event) => release(event, "input, select"));
}
