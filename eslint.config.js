// What eslint checks: the pages' scripts, and their tests in Node.

import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["**/build/", "**/.venv*/"] },
  js.configs.recommended,
  {
    rules: { "no-unused-vars": ["error", { ignoreRestSiblings: true }] }, // { left, out, ...rest }
  },
  {
    files: ["fuzz/**/*.js", "docs/playground/*.js", "tests/helpers/*.js"],
    languageOptions: { ecmaVersion: 2023, globals: globals.browser },
  },
  {
    files: ["tests/page/*.mjs"],
    languageOptions: { ecmaVersion: 2023, globals: { ...globals.node, ...globals.browser } },
  },
];
