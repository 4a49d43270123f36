// A C core in a page: a WebAssembly module, its memory, and where the fields of its structs are.
//
// The module holds its layouts itself, from the compiler: build_tools/wasm.py.

/** @typedef {number | bigint | string} Value of a field; numbers that JSON cannot hold are strings. */
/**
 * @typedef {{ [name: string]: Value | Value[] | Fields[] }} Fields by name, those of a struct inside a struct as
 *   "disc.reach"; an array has its items
 */

/**
 * @typedef {object} Core
 * @property {(name: string, ...values: (number | bigint)[]) => number} call a function; 64-bit
 *   arguments are bigints
 * @property {(name: string, ...values: (number | bigint)[]) => void} check a function that returns
 *   a WgStatus
 * @property {Record<string, number>} constants
 * @property {(bytes: number) => number} zeros memory, until `release`
 * @property {(struct: string, fields?: Fields) => number} make a struct, zero but for these fields
 * @property {(at: number, struct: string, fields: Fields) => void} set
 * @property {(at: number, struct: string, field: string) => number} get a field that is no larger
 *   than 2^53
 * @property {(at: number, struct: string, field: string) => bigint} whole a field of 64 bits
 * @property {(at: number, struct: string) => Record<string, number>} all fields of a struct
 * @property {(struct: string, field: string) => number} offset
 * @property {(struct: string) => number} size
 * @property {(values: ArrayLike<number | bigint>, kind: Kind) => number} array a copy
 * @property {<K extends Kind>(at: number, count: number, kind: K) => InstanceType<Arrays[K]>} view
 *   valid until the next call
 * @property {(at: number) => string} text up to its zero
 * @property {(name: string, bytes: number, fill: (at: number) => void) => number} table one that is
 *   filled once and stays
 * @property {() => void} release frees everything but the tables
 */

const ARRAYS = {
  uint8_t: Uint8Array,
  int32_t: Int32Array,
  uint32_t: Uint32Array,
  int64_t: BigInt64Array,
  uint64_t: BigUint64Array,
  double: Float64Array,
};
/** @typedef {typeof ARRAYS} Arrays */
/** @typedef {keyof Arrays} Kind */

const BAD = ["", "an array is too small", "a number is out of its range", "not enough memory for this world"];

/**
 * Starts a module.
 * @param {BufferSource} bytes
 * @returns {Promise<Core>}
 */
export async function openCore(bytes) {
  // The only thing that it asks of the system is the time, to return from long runs now and then.
  const clock = (/** @type {number} */ _id, /** @type {bigint} */ _precision, /** @type {number} */ at) => {
    new DataView(memory.buffer).setBigInt64(at, BigInt(Math.round(performance.now() * 1e6)), true);
    return 0;
  };
  const wanted = { wasi_snapshot_preview1: { clock_time_get: clock } };
  const { instance } = await WebAssembly.instantiate(bytes, wanted);
  const exported = /** @type {Record<string, any>} */ (instance.exports);
  const memory = /** @type {WebAssembly.Memory} */ (exported.memory);
  exported._initialize?.();
  const { constants, sizes, fields } = layoutsOf(exported, memory);
  /** @type {number[]} */
  let made = [];
  /** @type {Map<string, number>} */
  const tables = new Map();
  let data = new DataView(memory.buffer);

  // The memory's buffer is another one after it has grown.
  const now = () => (data.buffer === memory.buffer ? data : (data = new DataView(memory.buffer)));

  const place = (/** @type {string} */ struct, /** @type {string} */ field) => {
    const found = fields[struct]?.[field];
    if (!found) throw new Error(`the core has no ${struct}.${field}`);
    return found;
  };

  /** @type {Core} */
  const core = {
    constants,
    call: (name, ...values) => Number(exported[name](...values)),
    check(name, ...values) {
      const status = core.call(name, ...values);
      if (status) throw new Error(`${name}: ${BAD[status] ?? `status ${status}`}`);
    },
    zeros(bytes) {
      const at = exported.calloc(Math.max(1, bytes), 1);
      if (!at) throw new Error(BAD[3]);
      made.push(at);
      return at;
    },
    make(struct, values = {}) {
      const at = core.zeros(core.size(struct));
      core.set(at, struct, values);
      return at;
    },
    set(at, struct, values) {
      for (const [field, value] of Object.entries(values)) {
        const { offset, kind } = place(struct, field);
        const items = Array.isArray(value) ? value : [value];
        for (const [k, item] of items.entries()) {
          if (typeof item === "object") core.set(at + offset + k * core.size(kind), kind, item);
          else if (kind === "double") now().setFloat64(at + offset + 8 * k, Number(item), true);
          else if (kind.endsWith("int64_t")) now().setBigInt64(at + offset + 8 * k, BigInt(item), true);
          else now().setInt32(at + offset + 4 * k, Number(item), true);
        }
      }
    },
    get(at, struct, field) {
      const { offset, kind } = place(struct, field);
      if (kind === "double") return now().getFloat64(at + offset, true);
      if (kind === "int64_t") return Number(now().getBigInt64(at + offset, true));
      if (kind === "uint64_t") return Number(now().getBigUint64(at + offset, true));
      return now().getInt32(at + offset, true);
    },
    whole(at, struct, field) {
      const { offset, kind } = place(struct, field);
      const read = kind === "uint64_t" ? "getBigUint64" : "getBigInt64";
      return now()[read](at + offset, true);
    },
    all: (at, struct) =>
      Object.fromEntries(Object.keys(fields[struct]).map((field) => [field, core.get(at, struct, field)])),
    offset: (struct, field) => place(struct, field).offset,
    size(struct) {
      if (!sizes[struct]) throw new Error(`the core has no ${struct}`);
      return sizes[struct];
    },
    array(values, kind) {
      const at = core.zeros(values.length * ARRAYS[kind].BYTES_PER_ELEMENT);
      /** @type {any} */ (core.view(at, values.length, kind)).set(values);
      return at;
    },
    view: (at, count, kind) => /** @type {any} */ (new ARRAYS[kind](memory.buffer, at, count)),
    text: (at) => textAt(memory, at),
    table(name, bytes, fill) {
      const known = tables.get(name);
      if (known) return known;
      const at = core.zeros(bytes);
      made.pop();
      fill(at);
      tables.set(name, at);
      return at;
    },
    release() {
      for (const at of made) exported.free(at);
      made = [];
    },
  };
  return core;
}

/**
 * @param {WebAssembly.Memory} memory
 * @param {number} at
 */
function textAt(memory, at) {
  const bytes = new Uint8Array(memory.buffer, at);
  return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
}

/**
 * Reads the layouts that the compiler has put into a module.
 * @param {Record<string, any>} exported
 * @param {WebAssembly.Memory} memory
 */
function layoutsOf(exported, memory) {
  const names = textAt(memory, exported.wg_layout_names.value).trimEnd().split("\n");
  const numbers = new Int32Array(memory.buffer, exported.wg_layout_numbers.value, names.length);
  /** @type {Record<string, number>} */
  const constants = {};
  /** @type {Record<string, number>} */
  const sizes = {};
  /** @type {Record<string, Record<string, { offset: number, kind: string }>>} */
  const fields = {};
  for (const [k, name] of names.entries()) {
    const [path, kind] = name.split(" ");
    if (path.startsWith("=")) constants[path.slice(1)] = numbers[k];
    else if (!kind) sizes[path] = numbers[k];
    else {
      const dot = path.indexOf(".");
      (fields[path.slice(0, dot)] ??= {})[path.slice(dot + 1)] = { offset: numbers[k], kind };
    }
  }
  return { constants, sizes, fields };
}
