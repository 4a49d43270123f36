// Converts worlds between the server's messages and the editor's model.

/**
 * Returns a world from the server ready for editing, with the name and digest of its file, if it
 * has one.
 * @param {WorldMessage} message
 * @param {string} [name]
 * @param {string | null} [file]
 * @returns {EditedWorld}
 */
export function worldOf(message, name = "", file = null) {
  const text = atob(message.cells),
    cells = new Uint8Array(message.width * message.height);
  // ten times as fast as from()
  for (let k = 0; k < cells.length; k += 1) cells[k] = (text.charCodeAt(k >> 3) >> (k & 7)) & 1;
  return { ...message, others: message.others ?? [], cells, name, file, sheet: Symbol("sheet") };
}

/**
 * Returns a world as the server expects it.
 * @param {EditedWorld} world
 * @returns {WorldMessage}
 */
export function messageOf(world) {
  const bytes = new Uint8Array(Math.ceil(world.cells.length / 8));
  for (let k = 0; k < world.cells.length; k += 1) if (world.cells[k]) bytes[k >> 3] |= 1 << (k & 7);
  let text = "";
  for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
  const { name, file, sheet, ...sent } = world; // the first three are not sent
  return { ...sent, cells: btoa(text) };
}
