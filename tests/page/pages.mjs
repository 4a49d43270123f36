// Loads the pages' own scripts into Node: `const { numbersOf } = await player("decode")`.

import { readFileSync, readdirSync } from "node:fs";
import { register } from "node:module";
import vm from "node:vm";
import "./stand_in.mjs";

register("./resolve.mjs", import.meta.url);

const FUZZ = new URL("../../fuzz/", import.meta.url);
const PLAYER = new URL("player/page/", FUZZ);
const REPORT = new URL("report/page/", FUZZ);

export const player = (name) => import(new URL(`${name}.js`, PLAYER));
export const studio = (name) => import(new URL(`studio/page/${name}.js`, FUZZ));

/* The report's scripts, which are no modules: all but the one that starts the page, in one scope with the player's. */
export async function report() {
  const names = readdirSync(PLAYER).filter((name) => name.endsWith(".js"));
  const modules = await Promise.all(names.map((name) => import(new URL(name, PLAYER))));
  const scope = vm.createContext(Object.assign({ innerWidth: 1280 }, ...modules, { document, location, setTimeout, IntersectionObserver }));
  for (const name of readdirSync(REPORT).filter((one) => one.endsWith(".js") && one !== "start.js"))
    vm.runInContext(readFileSync(new URL(name, REPORT), "utf8"), scope);
  return scope;
}
