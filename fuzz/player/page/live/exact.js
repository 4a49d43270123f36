// Fractions of whole numbers of any size, for what Python computes with `fractions`.
//
// A number in a world means its shortest decimal, as in worldgen/lattice.py.

/** @typedef {{ over: bigint, under: bigint }} Fraction `under` is above 0, in lowest terms. */

/** @param {bigint} value */
const abs = (value) => (value < 0n ? -value : value);

/**
 * @param {bigint} a
 * @param {bigint} b
 */
function gcd(a, b) {
  [a, b] = [abs(a), abs(b)];
  while (b) [a, b] = [b, a % b];
  return a;
}

/**
 * @param {bigint} a
 * @param {bigint} b
 */
export const lcm = (a, b) => (a / gcd(a, b)) * b;

/**
 * @param {bigint | number} over
 * @param {bigint | number} under
 * @returns {Fraction}
 */
export function fraction(over, under = 1n) {
  [over, under] = [BigInt(over), BigInt(under)];
  if (under < 0n) [over, under] = [-over, -under];
  const shared = gcd(over, under) || 1n;
  return { over: over / shared, under: under / shared };
}

/**
 * Returns the number given by its shortest decimal.
 * @param {number} value finite
 * @returns {Fraction}
 */
export function exact(value) {
  const [digits, exponent = "0"] = String(value).split("e");
  const [whole, decimals = ""] = digits.split(".");
  const power = Number(exponent) - decimals.length;
  const number = BigInt(whole + decimals);
  return power < 0 ? fraction(number, 10n ** BigInt(-power)) : fraction(number * 10n ** BigInt(power));
}

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const add = (a, b) => fraction(a.over * b.under + b.over * a.under, a.under * b.under);

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const sub = (a, b) => fraction(a.over * b.under - b.over * a.under, a.under * b.under);

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const mul = (a, b) => fraction(a.over * b.over, a.under * b.under);

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const div = (a, b) => fraction(a.over * b.under, a.under * b.over);

/** @param {Fraction} a */
export const square = (a) => fraction(a.over * a.over, a.under * a.under);

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const isLess = (a, b) => a.over * b.under < b.over * a.under;

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const least = (a, b) => (isLess(b, a) ? b : a);

/**
 * @param {Fraction} a
 * @param {Fraction} b
 */
export const most = (a, b) => (isLess(a, b) ? b : a);

/** @param {Fraction} a */
export function floor({ over, under }) {
  const quotient = over / under;
  return over % under < 0n ? quotient - 1n : quotient;
}

/** @param {Fraction} a */
export const ceil = ({ over, under }) => -floor({ over: -over, under });

/**
 * Returns the nearest whole number; halves go up.
 * @param {Fraction} a
 */
export const nearest = (a) => floor({ over: 2n * a.over + a.under, under: 2n * a.under });

/**
 * Returns the nearest whole number; halves go to the even one.
 * @param {Fraction} a
 */
export function even(a) {
  const up = nearest(a);
  const isHalf = 2n * a.over + a.under === up * 2n * a.under;
  return isHalf && up % 2n ? up - 1n : up;
}

/**
 * Returns the largest whole number whose square is at most `value`.
 * @param {bigint} value 0 or more
 */
export function root(value) {
  if (value < 2n) return value;
  // Newton's method, from above.
  let low = 1n << BigInt((value.toString(2).length + 1) >> 1);
  for (;;) {
    const next = (low + value / low) >> 1n;
    if (next >= low) return low;
    low = next;
  }
}

/** @param {bigint} value */
const bits = (value) => value.toString(2).length;

/**
 * Returns the nearest float.
 * @param {Fraction} a
 */
export function float({ over, under }) {
  if (!over) return 0;
  // 64 bits of the quotient and one for what is left: rounding them is rounding all of it.
  const size = abs(over);
  const shift = 64 - bits(size) + bits(under);
  const [top, bottom] = shift > 0 ? [size << BigInt(shift), under] : [size, under << BigInt(-shift)];
  const quotient = ((top / bottom) << 1n) | (top % bottom ? 1n : 0n);
  const half = Math.trunc((shift + 1) / 2);
  const found = Number(quotient) * 2 ** -half * 2 ** -(shift + 1 - half);
  return over < 0n ? -found : found;
}

const doubles = new Float64Array(1);
const words = new BigInt64Array(doubles.buffer);

/**
 * Returns the next float above one that is 0 or more, or with -1 below one that is above 0.
 * @param {number} value
 * @param {1 | -1} side
 */
export function next(value, side) {
  doubles[0] = value;
  words[0] += BigInt(side);
  return doubles[0];
}

/**
 * Returns the largest float whose shortest decimal, squared, is at most a square.
 * @param {Fraction} squared
 */
export function rootDown(squared) {
  const { over, under } = squared;
  let shift = Math.max(0, 128 - bits(over) + bits(under));
  shift += shift % 2;
  let found = float(fraction(root((over << BigInt(shift)) / under), 1n << BigInt(shift / 2)));
  while (isLess(squared, square(exact(found)))) found = next(found, -1);
  while (!isLess(squared, square(exact(next(found, 1))))) found = next(found, 1);
  return found;
}

/**
 * Returns the smallest float whose shortest decimal, squared, is at least a square.
 * @param {Fraction} squared
 */
export function rootUp(squared) {
  const found = rootDown(squared);
  return isLess(square(exact(found)), squared) ? next(found, 1) : found;
}
