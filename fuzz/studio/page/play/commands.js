// What the keys command while the user drives a robot.

const SPEED = 1; // share of the top speed
const TURN_RATE = 3; // rad/s

const KEYS = { ArrowUp: "forward", w: "forward", ArrowDown: "back", s: "back", ArrowLeft: "left", a: "left", ArrowRight: "right", d: "right" };

/**
 * Returns what a key does while driving; undefined if nothing.
 * @param {string} key
 * @returns {string | undefined}
 */
export const directionOf = (key) => KEYS[key.length === 1 ? key.toLowerCase() : key];

/**
 * Returns the command for the keys that are held down: a share of the top speed, and a turn rate,
 * rad/s.
 * @param {Set<string>} held
 * @returns {[number, number]}
 */
export function commandOf(held) {
  const directions = [...held].map(directionOf);
  const count = (direction) => Number(directions.includes(direction));
  return [(count("forward") - count("back")) * SPEED, (count("left") - count("right")) * TURN_RATE];
}

/**
 * Appends steps of a command to a list, merging it with an equal command before it.
 * @param {[number, number, number][]} commands
 * @param {number} steps
 * @param {[number, number]} command
 */
export function addSteps(commands, steps, [speed, turnRate]) {
  const last = commands.at(-1);
  if (last && last[1] === speed && last[2] === turnRate) last[0] += steps;
  else commands.push([steps, speed, turnRate]);
}
