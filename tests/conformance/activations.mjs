// activations.f16: little-endian half floats, as "From bytes to values" of docs/pack-format.md has them.
import { need } from "./refusal.mjs";

/** The numbers of the file, all of them finite, and within 0..1 exactly where the manifest says so. */
export function readActivations(bytes, { clamped }) {
  const numbers = Float64Array.from({ length: bytes.length / 2 }, (_, n) => half(bytes.readUInt16LE(2 * n)));
  need(numbers.every(Number.isFinite), "an activation is not finite");
  need(numbers.every((number) => number >= 0 && number <= 1) === clamped, "activations are not clamped as stated");
  return numbers;
}

/** IEEE 754 binary16: a sign, 5 bits of exponent, 10 of fraction. */
function half(bits) {
  const [sign, exponent, fraction] = [bits & 0x8000 ? -1 : 1, (bits >> 10) & 31, (bits & 1023) / 1024];
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction) : 2 ** -14 * fraction);
}
