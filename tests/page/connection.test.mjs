// The connection to the server: answers are matched to requests, and faults are reported.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import "./stand_in.mjs";
import { Ended, makeConnection } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";
import { GIVEN, LIMITS } from "./samples.mjs";

const sockets = [];
const waits = [];

class Socket {
  static OPEN = 1;
  readyState = 1;
  acts = {};
  sent = [];

  constructor(address, offered) {
    Object.assign(this, { address, offered });
    sockets.push(this);
  }

  addEventListener(name, act) {
    this.acts[name] = act;
  }

  send(text) {
    this.sent.push(JSON.parse(text));
  }

  say(message) {
    this.acts.message({ data: JSON.stringify(message) });
  }

  close(code = 1006, reason = "") {
    this.readyState = 3;
    return this.acts.close({ code, reason });
  }
}

globalThis.WebSocket = Socket;
globalThis.fetch = async () => ({ ok: true });

async function connected(limits = LIMITS) {
  const told = { begun: [], lost: [] };
  const connection = makeConnection(GIVEN, (said) => told.begun.push(said), (...given) => told.lost.push(given), Promise.resolve());
  await new Promise((done) => setImmediate(done));
  sockets.at(-1).say({ protocol: 2, folder: "/here", limits });
  return { connection, told, socket: sockets.at(-1) };
}

const later = globalThis.setTimeout;
beforeEach(() => {
  sockets.length = waits.length = 0;
  // tests decide when it reconnects
  globalThis.setTimeout = (act, ms) => (ms > 100 ? waits.push([act, ms]) : later(act, ms));
});

test("each answer is matched to its request, whatever the order", async () => {
  const { connection, socket } = await connected();
  const asked = [connection.ask("files"), connection.ask("decide", { world: 1 })];
  const [files, decide] = socket.sent;
  assert.deepEqual([files.do, decide.do, decide.world], ["files", "decide", 1]);
  socket.say({ id: decide.id, answer: "second" });
  socket.say({ id: files.id, answer: "first" });
  assert.deepEqual(await Promise.all(asked), ["first", "second"]);
});

test("parts of an answer arrive before it, once each", async () => {
  const { connection, socket } = await connected();
  const parts = [];
  const asked = connection.ask("run", {}, (part) => parts.push(part));
  const { id } = socket.sent[0];
  for (const part of [1, 2]) socket.say({ id, part });
  socket.say({ id, answer: {} });
  await asked;
  assert.deepEqual(parts, [1, 2]);
});

test("the server's objection is reported in its own words, and a replaced request ends", async () => {
  const { connection, socket } = await connected();
  const asked = [connection.ask("save"), connection.ask("decide")];
  socket.say({ id: socket.sent[0].id, error: { code: "disk-refuses", problem: "the disk is full", remedy: "make room", terminal: false, opens: "", facts: { file: "w.grid" }, line: null, source: null } });
  socket.say({ id: socket.sent[1].id, ended: true });
  await assert.rejects(asked[0], (error) => error instanceof Refused && error.message === "the disk is full; make room" && error.code === "disk-refuses" && error.facts.file === "w.grid");
  await assert.rejects(asked[1], Ended);
});

test("a message that is too large is refused, and the connection stays open", async () => {
  const { connection, socket } = await connected();
  await assert.rejects(connection.ask("files", { more: "ü".repeat(17 << 20) }), (error) => error instanceof Refused && /more than 32 MiB/.test(error.message));
  assert.equal(socket.sent.length, 0);
  const asked = connection.ask("files");
  socket.say({ id: socket.sent[0].id, answer: "there" });
  assert.equal(await asked, "there");
});

test("a lost connection ends waiting requests, and is retried at growing intervals", async () => {
  const { connection, told } = await connected();
  const asked = connection.ask("run");
  await Promise.all([assert.rejects(asked, Ended), sockets[0].close()]);
  assert.deepEqual(told.lost, [[false, ""]]);
  await assert.rejects(connection.ask("files"), Ended);
  const times = [];
  for (let k = 0; k < 8; k += 1) {
    const [[act, ms]] = waits.splice(0);
    times.push(ms);
    act();
    await sockets.at(-1).close();
  }
  assert.ok(times[0] === 300 && times.at(-1) === 3000 && times.every((ms, k) => k === 0 || ms >= times[k - 1]));
});

test("a server that no longer knows the page is distinguished from one that has ended", async () => {
  const { told } = await connected();
  await sockets[0].close();
  waits.splice(0)[0][0]();
  await sockets.at(-1).close(); // refused before the first message
  assert.deepEqual(told.lost.at(-1), [true, ""]);
});

test("one page too many is given the server's reason", async () => {
  const { told } = await connected();
  await sockets[0].close(4000, "1 pages are open");
  assert.deepEqual(told.lost, [[false, "1 pages are open"]]);
});

test("if the server finds a message too large, waiting requests are refused with a remedy", async () => {
  const { connection, socket } = await connected();
  const asked = connection.ask("save");
  await Promise.all([assert.rejects(asked, (error) => error instanceof Refused && /draw a smaller world/.test(error.message)), socket.close(1009)]);
});

test("messages above the server's own limit are not sent", async () => {
  const { connection, socket } = await connected({ ...LIMITS, message: 2 ** 20 });
  const asked = connection.ask("save", { text: "x".repeat(2 ** 20) });
  await assert.rejects(asked, (error) => error instanceof Refused && /more than 1 MiB/.test(error.message));
  asked.stop();
  assert.deepEqual(socket.sent, []);
});

test("a stopped request asks the server to stop once", async () => {
  const { connection, socket } = await connected();
  const asked = connection.ask("run");
  asked.stop();
  const [run, cancel] = socket.sent;
  assert.deepEqual([cancel.do, cancel.of], ["cancel", run.id]);
  socket.say({ id: run.id, ended: true });
  await assert.rejects(asked, Ended);
  asked.stop();
  assert.equal(socket.sent.length, 2);
});
