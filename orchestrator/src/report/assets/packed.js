"use strict";
// What the page holds as text.
const Packed = (() => {
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
  /** What gzip has packed. */
  const opened = text => new Response(new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  /** The bytes of an element; of one that is packed, a promise of them. */
  const held = ({ type, textContent }) => type === "application/gzip" ? opened(textContent).then(buffer => new Uint8Array(buffer)) : bytes(textContent);
  /** Numbers whose bytes stand apart, all first ones, then all second ones, and so on: so they can be packed. */
  const numbers = (apart, Type) => {
    const size = Type.BYTES_PER_ELEMENT, count = apart.length / size, whole = new Uint8Array(apart.length);
    for (let place = 0; place < size; place++) {
      const from = place * count;
      for (let i = 0; i < count; i++) whole[i * size + place] = apart[from + i];
    }
    return new Type(whole.buffer);
  };
  return { opened, held, numbers };
})();
