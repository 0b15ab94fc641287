// Names that fit over a vehicle: of long ones, what all of them begin or end with is left out.

const LONGEST = 16; // letters of a name that is left whole

/** Return a short form of each name; those of different names differ. */
export function shortNames(names) {
  if (names.length < 2 || names.every((name) => name.length <= LONGEST)) return names;
  const start = commonWords(names);
  const end = commonWords(names.map((name) => reversed(name.slice(start))));
  return names.map((name) => `${start ? "…" : ""}${name.slice(start, name.length - end)}${end ? "…" : ""}`);
}

/** Return the number of letters of the words that all names begin with, up to a character between words. */
function commonWords([first, ...others]) {
  const differs = (letter, at) => others.some((name) => name[at] !== letter);
  const found = [...first].findIndex(differs);
  return first.slice(0, found < 0 ? first.length : found).replace(/[a-z0-9]*$/i, "").length;
}

function reversed(name) {
  return [...name].reverse().join("");
}
