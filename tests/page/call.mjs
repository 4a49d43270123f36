// Calls functions of the pages for tests in Python: reads [[module, function, arguments],
// ...] and writes their results.

import { readFileSync } from "node:fs";
import "./stand_in.mjs";

const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
const results = [];
for (const [module, name, given] of JSON.parse(readFileSync(0, "utf8")))
  results.push((await import(`#${module}.js`))[name](...given) ?? null);
process.stdout.write(JSON.stringify(results, plain));
