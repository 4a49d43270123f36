// Driving by hand: what keys mean, and how commands are combined.

import assert from "node:assert/strict";
import test from "node:test";

import "./stand_in.mjs";
import { addSteps, commandOf, directionOf } from "#studio/play/commands.js";

test("arrow keys and letters steer, with or without Shift or Caps Lock", () => {
  assert.deepEqual(["ArrowUp", "w", "W", "ArrowLeft", "d", "q", "Enter"].map(directionOf), ["forward", "forward", "forward", "left", "right", undefined, undefined]);
});

test("keys held together combine, and opposite ones cancel out", () => {
  const turn = commandOf(new Set(["ArrowLeft"]))[1];
  assert.ok(turn > 0); // counter-clockwise
  assert.deepEqual(commandOf(new Set(["ArrowUp", "w", "a"])), [1, turn]);
  assert.deepEqual(commandOf(new Set(["s", "d"])), [-1, -turn]);
  assert.deepEqual(commandOf(new Set(["w", "s", "a", "d"])), [0, 0]);
});

test("equal consecutive commands are merged", () => {
  const commands = [];
  addSteps(commands, 2, [1, 0]);
  addSteps(commands, 3, [1, 0]);
  addSteps(commands, 1, [1, 3]);
  addSteps(commands, 4, [1, 0]);
  assert.deepEqual(commands, [[5, 1, 0], [1, 1, 3], [4, 1, 0]]);
});
