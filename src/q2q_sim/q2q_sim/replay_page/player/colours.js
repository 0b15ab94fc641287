// Colours that colour-blind people tell apart (q2q_model.palette, after Okabe and Ito).

// Darker first: a lighter blue is nearly the sky blue of the palette.
const TINTS = [
  [0, "#000000"],
  [0.4, "#000000"],
  [0.4, "#ffffff"],
];

export const CALM_AIR = "#56b4e9";
export const PUSHING_AIR = "#d55e00";

/** Return the colour of a vehicle; after all of a palette, the same ones darker, then lighter. */
export function tinted(palette, vehicle) {
  const [share, tint] = TINTS[Math.floor(vehicle / palette.length) % TINTS.length];
  return mixed(palette[vehicle % palette.length], tint, share);
}

/** Return a colour between two, `share` of the second. */
export function mixed(first, second, share) {
  const parts = channels(first).map((value, at) => Math.round(value + share * (channels(second)[at] - value)));
  return `#${parts.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}

/** Return red, green and blue of #rrggbb, 0 to 255. */
function channels(colour) {
  return [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16));
}

/** Set an element light or dark, as its page is; return its colours (replay.css). */
export function themeOf(element) {
  const follows = getComputedStyle(element).colorScheme.includes("dark");
  element.toggleAttribute("dark", follows && matchMedia("(prefers-color-scheme: dark)").matches);
  const style = getComputedStyle(element);
  const value = (name) => style.getPropertyValue(`--${name}`).trim();
  return { ink: value("ink"), faint: value("faint"), room: value("room"), grid: value("grid") };
}
