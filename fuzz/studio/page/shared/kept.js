// Stores choices made in an opened folder in this browser, which may store nothing, or have no room
// left.

const KEPT = "worldgen-studio-kept-"; // followed by the choice's name and the folder

/**
 * Returns what was stored for a folder under a name; null if nothing was.
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
 * Stores a value for a folder under a name.
 * @param {string} folder
 * @param {string} name
 * @param {any} value
 */
export function keep(folder, name, value) {
  try {
    localStorage.setItem(`${KEPT}${name}-${folder}`, JSON.stringify(value));
  } catch {
    // the page uses the default when it is reloaded
  }
}

/**
 * Returns what this tab stored for a folder under a name, for its own reloads; null if nothing was.
 * @param {string} folder
 * @param {string} name
 * @returns {any}
 */
export function keptInTab(folder, name) {
  try {
    return JSON.parse(sessionStorage.getItem(`${KEPT}${name}-${folder}`) ?? "null");
  } catch {
    return null;
  }
}

/**
 * Stores a value for reloads of this tab, where another tab does not replace it.
 * @param {string} folder
 * @param {string} name
 * @param {any} value
 */
export function keepInTab(folder, name, value) {
  try {
    sessionStorage.setItem(`${KEPT}${name}-${folder}`, JSON.stringify(value));
  } catch {
    // a reload then uses what the browser stores for all tabs
  }
}
