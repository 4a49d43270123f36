// Judges questions as a page's worker does: one in a line of the input, answers in lines of the output.

import { readFileSync } from "node:fs";
import { openCore } from "#player/live/core.js";
import { judge } from "#player/live/judge.js";

const root = new URL("../../", import.meta.url);
const [prover, simulator] = await Promise.all(
  ["worldgen", "sim"].map((name) => openCore(readFileSync(new URL(`${name}/_core.wasm`, root)))),
);
for (const line of readFileSync(0, "utf8").trim().split("\n")) {
  const { proof, run, live } = await judge({ prover, simulator }, JSON.parse(line), async () => {});
  if (run) run.drawn.open = Object.fromEntries(Object.entries(run.drawn.open).map(([name, column]) => [name, column && [...column]]));
  console.log(JSON.stringify({ proof, run, live }));
}
