// Links to what a page shows.

import assert from "node:assert/strict";
import { test } from "node:test";
import "./stand_in.mjs";
import { linkTo, readLink } from "#studio/shared/links.js";

test("links survive writing and reading, whatever the names are", () => {
  const shows = { world: "found/loop & turn=1.grid", robots: "./mine.py:Robot+gain=0.5,bug1", motion: "swept" };
  assert.deepEqual(readLink(linkTo("play", shows)), { page: "play", shows });
});

test("empty values are omitted, and a page without values is a link", () => {
  assert.equal(linkTo("draw", { world: "", step: null }), "#draw");
  assert.deepEqual(readLink("#campaign"), { page: "campaign", shows: {} });
  assert.deepEqual(readLink(""), { page: "", shows: {} });
});
