// Unpacks the archive next to it, makes its modules importable by name, and loads the last: the element.
const archive = document.querySelector("script.q2q-replay-archive").textContent;

async function unpacked(base64) {
  const letters = atob(base64);
  const packed = new Uint8Array(letters.length);
  for (let at = 0; at < packed.length; at++) packed[at] = letters.charCodeAt(at);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(stream).text());
}

function withUrls(source, urls) {
  return source.replace(/(from\s*|import\s*)(["'])([^"'\n]+)\2/g, (found, words, quote, name) =>
    urls.has(name) ? `${words}${quote}${urls.get(name)}${quote}` : found,
  );
}

async function load() {
  const { modules, style } = await unpacked(archive);
  const urls = new Map();
  for (const [name, source] of modules) {
    const named = `${withUrls(source, urls)}\n//# sourceURL=q2q-replay/${name.replace("./", "")}`;
    urls.set(name, URL.createObjectURL(new Blob([named], { type: "text/javascript" })));
  }
  const { defineElement } = await import(urls.get(modules.at(-1)[0]));
  defineElement(style);
}

if (!customElements.get("q2q-replay")) {
  if (window.DecompressionStream && window.OffscreenCanvas) await load();
  else document.querySelector("q2q-replay").append("The replay needs a browser of 2024 or later.");
}
