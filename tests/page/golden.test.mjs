// Golden pictures of the player: a digest of everything that is sent to the canvas. If a picture
// should change, look at it in a browser, then replace its digest by the one in the message.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { test } from "node:test";
import "./stand_in.mjs";
import { drawScene, drawSmall, SHOWN } from "#player/picture/map.js";
import { numbers, roomOf, runOf } from "./samples.mjs";

const witness = { ms: numbers([0, 4000, 9000]), x: numbers([150, 400, 1250]), y: numbers([150, 750, 850]), per_cell: 100 };
const room = roomOf(14, 10, [[7, 2], [7, 3], [7, 4], [7, 5]], { witness });
const loop = runOf({ at: [0, 2, 4, 6, 8, 10], x: [1.5, 3, 6.3, 6.3, 3, 3], y: [1.5, 3, 3, 5, 5, 3], bump: [0, 0, 1, 1, 0, 0], loop: [2, 8] });
const stalled = runOf({ at: [0, 4, 8], x: [1.5, 6.3, 6.3], y: [1.5, 4.5, 4.6], bump: [0, 1, 1] });
const body = { ...room, footprint: [[1, 0.5], [-0.5, 0.5], [-0.5, -0.5], [1, -0.5]], aim: 1.57, radius: 1.1 };
const fleet = { ...room, others: [{ start: [11, 2, 3.1], target: [2, 7, 0.5], radius: 0.7, witness: null }] };
const blocked = [{ ...loop, blocked_by: [2] }, { ...runOf({ at: [0, 2, 10], x: [11, 8.5, 8.5], y: [2, 3, 3], loop: [2, 8] }), blocked_by: [1] }];

const PICTURES = {
  "a card of a loop": [(canvas) => drawSmall(canvas, { world: room, run: loop, sensors: null }), "7405b1f0a9f94808"],
  "a card of a stalled run": [(canvas) => drawSmall(canvas, { world: room, run: stalled, sensors: null }), "d1147b1b6446eefd"],
  "a card of a body": [(canvas) => drawSmall(canvas, { world: body, run: loop, sensors: null }), "10bdd3821a104d78"],
  "a card of robots that block each other": [(canvas) => drawSmall(canvas, { world: fleet, run: blocked[0], number: 1, others: [{ run: blocked[1], number: 2 }], sensors: null }), "4156d93c7060d301"],
  "a moment in the player": [(canvas) => drawScene(canvas, { world: room, run: loop, sensors: { beams: 4, field: 0, range: 4, signal: true }, step: 5, show: SHOWN }), "c20cdb0b113181f7"],
  "a world": [(canvas) => drawScene(canvas, { world: room, run: null, show: { witness: true } }), "300f937b7bc018cb"],
};

for (const [name, [draw, digest]] of Object.entries(PICTURES))
  test(`golden picture: ${name}`, () => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { clientWidth: 190, clientHeight: 190 });
    draw(canvas);
    // Hundredths of a pixel, so that no digit of a sine matters.
    const rounded = (value) => (typeof value === "number" ? Math.round(100 * value) + 0 : value instanceof Object && !Array.isArray(value) ? "picture" : value);
    const calls = canvas.context.calls.map(({ name: call, given, fillStyle, strokeStyle, lineWidth, globalAlpha, dash }) => [call, ...given.map(rounded), rounded(fillStyle), strokeStyle, rounded(lineWidth), rounded(globalAlpha), dash.map(rounded)]);
    assert.ok(calls.length > 10);
    assert.equal(createHash("sha256").update(JSON.stringify(calls)).digest("hex").slice(0, 16), digest);
  });
