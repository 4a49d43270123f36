// What this browser keeps of the choices made in an opened folder; a browser may keep nothing, or be full of a drawing.

const KEPT = "worldgen-studio-kept-"; // and the choice's name and the folder

/**
 * What was kept for a folder under a name; null where nothing was.
 * @param {string} folder
 * @param {string} name
 * @returns {any}
 */
export function keptOf(folder, name) {
  try {
    return JSON.parse(localStorage.getItem(`${KEPT}${name}-${folder}`) ?? "null");
  } catch {
    return null;
  }
}

/**
 * Keeps something for a folder under a name.
 * @param {string} folder
 * @param {string} name
 * @param {any} value
 */
export function keep(folder, name, value) {
  try {
    localStorage.setItem(`${KEPT}${name}-${folder}`, JSON.stringify(value));
  } catch {
    // the page begins with what is usual when it is loaded anew
  }
}
