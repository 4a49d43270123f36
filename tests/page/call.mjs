// Calls functions of the pages for tests in Python: reads [[module, function, arguments], ...] and writes what they give.

import { readFileSync } from "node:fs";
import { player, studio } from "./pages.mjs";

const load = { player, studio };
const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
const results = [];
for (const [module, name, given] of JSON.parse(readFileSync(0, "utf8"))) {
  const [page, part] = module.split("/");
  results.push((await load[page](part))[name](...given) ?? null);
}
process.stdout.write(JSON.stringify(results, plain));
