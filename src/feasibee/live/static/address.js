// The page's address keeps seed, run, point and changes, so that a copied address shows the same run.

/** @typedef {{seed: string | null, run: string | null}} Which Run of a point; null: the server's choice. */
/** @typedef {{which: Which, point: number | null, against: string, changes: Record<string, unknown>}} Kept */

/**
 * Read what the address keeps.
 * @returns {Kept}
 */
export function readAddress() {
  const kept = new URLSearchParams(location.hash.slice(1));
  /** @type {Record<string, unknown>} */
  const changes = {};
  for (const [path, text] of kept) {
    if (!path.includes(".") && !["preset", "events"].includes(path)) continue;
    try {
      changes[path] = JSON.parse(text);
    } catch {
      changes[path] = text;
    }
  }
  const point = kept.has("point") ? Number(kept.get("point")) : null;
  const which = { seed: kept.get("seed"), run: kept.get("run") };
  return { which, point, against: kept.get("against") ?? "", changes };
}

/**
 * Keep a run in the address, without a new entry in the browser's history.
 * @param {{seed: string, run: string}} which
 * @param {number | null} point
 * @param {string} against
 * @param {Record<string, unknown>} changes
 */
export function writeAddress({ seed, run }, point, against, changes) {
  const kept = new URLSearchParams({ seed, run });
  if (point !== null) kept.set("point", String(point));
  if (against) kept.set("against", against);
  for (const [path, value] of Object.entries(changes)) kept.set(path, JSON.stringify(value));
  history.replaceState(null, "", `#${kept}`);
}
