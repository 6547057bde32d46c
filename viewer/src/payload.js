// The bytes that the page carries: see src/report/viewer/sections.rs.

const ARRAYS = { u32: Uint32Array, f32: Float32Array, f64: Float64Array };

/** What the page's text holds: `header`, and `section(name)` as an array of numbers. */
export async function readPayload(text) {
  const bytes = await gunzip(fromBase64(text));
  const length = new DataView(bytes).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const start = 8 * Math.ceil((4 + length) / 8);
  const list = new Map(header.sections.map((section) => [section.name, section]));
  const section = (name) => {
    const { numbers, at, bytes: size } = list.get(name);
    if (numbers === 'varint') return varints(new Uint8Array(bytes, start + at, size));
    const Array = ARRAYS[numbers];
    return new Array(bytes, start + at, size / Array.BYTES_PER_ELEMENT);
  };
  return { header, section };
}

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const packed = atob(text.trim());
  const bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
  return bytes;
}

async function gunzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

/** Seven bits a byte, the lowest first; the last byte of each number is below 128. */
function varints(bytes) {
  let count = 0;
  for (const byte of bytes) count += byte < 128;
  const numbers = new Uint32Array(count);
  let value = 0;
  let shift = 0;
  let at = 0;
  for (const byte of bytes) {
    value |= (byte & 127) << shift;
    shift += 7;
    if (byte < 128) {
      numbers[at++] = value;
      value = shift = 0;
    }
  }
  return numbers;
}

/** From 0, 1, 2, 3 … back to 0, -1, 1, -2 … */
export const unzigzag = (code) => (code >>> 1) ^ -(code & 1);

/** Numbers that were written as differences. */
export function sums(codes) {
  let sum = 0;
  return Uint32Array.from(codes, (code) => (sum = (sum + unzigzag(code)) | 0));
}

/** Where each of several parts begins whose lengths these are, and the end of the last. */
export function starts(lengths) {
  const at = new Uint32Array(lengths.length + 1);
  for (let i = 0; i < lengths.length; i++) at[i + 1] = at[i] + lengths[i];
  return at;
}
