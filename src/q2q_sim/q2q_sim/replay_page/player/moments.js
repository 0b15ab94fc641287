// Marked moments of a run: buttons that go to them, of many the first ones at first.

import { button, group } from "./controls.js";

const MOST = 10; // moments with a button until all are asked for

/** Return buttons that go to the marked moments of a run; of many, a last one adds the others. */
export function momentButtons(events, playback) {
  const buttons = events.map(({ t, words }) => button(`${playback.words(t)} s: ${words}`, () => playback.seek(t), "event"));
  const rest = buttons.splice(MOST);
  const more = button(`${rest.length} more`, () => more.replaceWith(...rest), "event");
  return group("events", rest.length > 0 ? [...buttons, more] : buttons);
}
