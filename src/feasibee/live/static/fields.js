// What the user can change, as far as all pages have it; no elements.

/** @type {Record<string, Exclude<keyof Settings, "events">>} */
export const SETTINGS = {
  "robots.count": "robots",
  "tasks.count": "tasks",
  "decision.strategy": "strategy",
  "sensing.range": "sight",
  "radio.range": "radio",
  "robots.speed": "speed",
  seed: "seed",
  run: "run",
};
const RANGED = ["sensing.range", "radio.range", "robots.speed"];

/** @type {Field[]} */
const FIRST = [
  { path: "robots.count", name: "robots", kind: "integer", min: 1, slide: [1, 100, 1] },
  { path: "tasks.count", name: "tasks", kind: "integer", slide: [0, 100, 1] },
  { path: "decision.strategy", name: "strategy", kind: "choice" },
  { path: "against", name: "compare with", kind: "choice" },
  { path: "sensing.range", name: "sensing range", kind: "quantity", min: 0.01, slide: [0.1, 10, 0.1] },
  { path: "radio.range", name: "radio range", kind: "quantity", min: 0.01, slide: [0.1, 10, 0.1] },
  { path: "robots.speed", name: "speed", kind: "quantity", slide: [0, 2, 0.05] },
  { path: "seed", name: "seed", kind: "integer", max: 2n ** 64n - 1n, slide: [0, 99, 1] },
  { path: "run", name: "run", kind: "integer", max: 2 ** 32 - 1, slide: [0, 99, 1] },
];

/**
 * Return the strategies of other packages, which only a server has.
 * @param {{fields: Field[]}[] | null} form All fields, if there is a server.
 */
export function othersOf(form) {
  const fields = (form ?? []).flatMap((part) => part.fields);
  return fields.find(({ path }) => path === "decision.strategy")?.choices ?? [];
}

/**
 * Return the fields of all pages, with the bounds of what the page can change by itself, and the choices of strategies.
 * @param {Opened} opened
 * @param {{fields: Field[]}[] | null} form
 */
export function firstFields({ most, patches, strategies }, form) {
  const bounds = /** @type {Record<string, number>} */ (most),
    names = strategies.map(({ name }) => name),
    shown = FIRST.filter(({ path }) => patches || form || !RANGED.includes(path));
  /** @type {Record<string, string[]>} */
  const choices = {
    "decision.strategy": [...new Set([...names, ...othersOf(form)])],
    against: ["", ...names],
  };
  return shown.map((field) => {
    const { path, max = bounds[SETTINGS[path]] } = field;
    return { ...field, max, choices: choices[path] };
  });
}

/**
 * Return the setting that the page itself can change for a path; undefined if only a server can.
 * @param {string} path
 * @param {Pick<Opened, "counted" | "patches">} opened
 */
export function settingOf(path, { counted, patches }) {
  const isFixed = RANGED.includes(path) ? !patches : path.endsWith(".count") && Boolean(counted);
  return isFixed ? undefined : SETTINGS[path];
}

/**
 * Whether only Python can read a value, such as 6 m.
 * @param {string} path
 * @param {unknown} value
 */
export const isPythons = (path, value) =>
  typeof value === "string" && (path === "events" || RANGED.includes(path));

/**
 * Return the number that a text is; null if it is none within the bounds of a field.
 * @param {string} text
 * @param {Field} field
 */
export function numberOf(text, { kind, min = 0, max = 0 }) {
  const isWhole = kind === "integer";
  if (isWhole ? !/^\d{1,20}$/.test(text) : !text) return null;
  const number = isWhole ? BigInt(text) : Number(text); // seeds need more than 53 bits
  return number >= min && number <= max ? number : null;
}
