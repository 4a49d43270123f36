// Links to what a page shows: a world, a run in it, a folder of failures, one failure. They only
// work in a browser that has access.

import { Refused } from "#studio/shared/refusals.js";

/**
 * Returns the page of a link and what to show on it.
 * @param {string} hash - Of the address, such as "#play?world=trap.grid&robots=bug1"
 * @returns {{page: string, shows: Record<string, string>}}
 */
export function readLink(hash) {
  const [page, , shows = ""] = hash.slice(1).split(/(\?)(.*)/s);
  return { page, shows: Object.fromEntries(new URLSearchParams(shows)) };
}

/**
 * Returns names joined into one text for a link; a composition's name itself contains commas.
 * @param {string[]} names
 * @returns {string}
 */
export function joinNames(names) {
  return names.map((name) => name.replaceAll("%", "%25").replaceAll(",", "%2C")).join(",");
}

/**
 * Returns the names in a text that `joinNames` made.
 * @param {string} text
 * @returns {string[]}
 */
export function splitNames(text) {
  return text.split(",").map((name) => name.replaceAll("%2C", ",").replaceAll("%25", "%"));
}

/**
 * Returns whether a robot can be one of those offered, perhaps with options of its own.
 * @param {string} robot
 * @param {string[]} offered - Names of controllers
 * @returns {boolean}
 */
export function isOfferedAs(robot, offered) {
  return offered.some((name) => robot === name || robot.startsWith(`${name}+`)) || robot.startsWith("behaviours");
}

/**
 * Returns what a link to a generated world contains.
 * @param {{family: string, seed: string, parameters: object}} message - The request to generate it
 * @returns {Record<string, string>}
 */
export function madeOf({ family, seed, parameters }) {
  const changed = JSON.stringify(parameters);
  return { family, world_seed: seed, parameters: changed === "{}" ? "" : changed };
}

/**
 * Returns the request to generate the world of a link.
 * @param {Record<string, string>} shows
 * @returns {{family: string, seed: string, parameters: object}}
 */
export function madeIn({ family, world_seed: seed = "1", parameters }) {
  try {
    return { family, seed, parameters: JSON.parse(parameters || "{}") };
  } catch {
    throw new Refused("The link's parameters cannot be read; copy the whole link.");
  }
}

/**
 * Returns a link, without values that are empty or unknown.
 * @param {string} page
 * @param {Record<string, string | number | null | undefined>} shows
 * @returns {string}
 */
export function linkTo(page, shows) {
  const given = Object.entries(shows).filter(([, value]) => value !== "" && value !== null && value !== undefined);
  const words = new URLSearchParams(given.map(([name, value]) => [name, String(value)])).toString();
  return words ? `#${page}?${words.replaceAll("%2F", "/").replaceAll("%2C", ",").replaceAll("%3A", ":")}` : `#${page}`;
}
