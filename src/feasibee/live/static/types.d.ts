// The shapes that modules share: what Python gives, what workers send, and what is drawn of it. Only for tsc.

type Arena = import("./arena.js").Arena;
type Engine = import("./engine.js").Engine;
type Lane = import("./lane.js").Lane;
type Page = import("./app.js").Page;
type RunHistory = import("./history.js").History;
type Shades = Record<import("./theme.js").Shade, string>;
type World = import("./world.js").World;

type Point = [number, number]; // in units
type Pointer = { clientX: number; clientY: number }; // a position of the page
type Place = Pointer & { arena: Arena }; // where the pointer is

// What the pointer does. held: what begin has returned, where the pointer was pressed; null once that is dropped, as by
// Escape, or without begin.
type Tool = {
  label: string;
  help: string;
  begin?: (place: Place) => any;
  move?: (place: Place, held: any) => void;
  end: (place: Place, held: any) => void;
};

// What a page is given, from page.py.
type Given = {
  name: string;
  version: string;
  server: boolean;
  form: { name: string; fields: Field[] }[] | null; // the fields, with a server only
  wasm: string; // the engine, compressed
  replays: { replays: Replay[]; pick: string; found: number } | null;
  field: { address: string; hz: number | null; which: string } | null;
  opened: Opened;
  prediction: Prediction | null;
};

// A scenario that is opened, from scene.py.
type Opened = {
  toml: string;
  packets: { bytes: string; starts: number[] }; // that of all strategies, then those of each; see pages.c
  reached: { columns: number; bits: number; cells: string } | null; // a bit for each cell that robots reach
  strategies: Strategy[];
  counted: string; // why the numbers at the start can't be changed; empty if they can
  legend: Record<string, boolean>; // which entries it needs, of those that not all need
  threshold: number;
  unit: [string, string]; // numerator and denominator, of fixed point
  most: { robots: number; tasks: number };
  settings: Settings;
  patches: boolean; // whether ranges and speed may differ from those of the scenario
  lengths: Lengths;
  run: { steps: number; stops: boolean };
  point: number | null; // of a sweep
  fields: Record<string, any>; // as shown, by path
  units: Record<string, string>; // by path
  changed: string[]; // paths of fields that differ from the defaults
  drawn: Point[][]; // walls, as polygons
  cell: number;
  proof: string;
  seconds: number; // of a step; 0 if that isn't known
  failures?: Record<string, string>; // why a user's strategy may fail, by number; from packet.py
  wasm: string | null; // if not the page's
};

// What stays as it is in a run; view: in degrees; changes: whether robots or tasks may come and go; acts: whether robots
// go to tasks and do them.
type Lengths = Record<"diameter" | "sight" | "view" | "radio", number> &
  Record<"walls" | "changes" | "acts", boolean> &
  Record<"robotClasses" | "taskClasses", string[]> & { size: Point; plan: Plan | null };

// A floor plan: an image in base64, whose opacity says how dark each cell is; sizes in units.
type Plan = { image: string; size: Point; zones: { name: string; polygons: Point[][]; at: Point }[] };

// rule: a line; fixed: why events can't change its world; quality, decide: what these functions do.
type Strategy = Record<"name" | "rule" | "fixed" | "quality" | "decide", string> &
  Record<"declares" | "knows" | "judges" | "knowledge" | "byName" | "forgets", boolean>;

// What a reader may change; sight, radio, speed: as typed.
type Settings = Record<"robots" | "tasks" | "strategy" | "run" | "sight" | "radio" | "speed", number> & {
  seed: string;
  events: WorldEvent[];
};

// How many come at a step, or go; or where; or which one goes or is put there. A scenario's may also change its errors.
type Change = Partial<Record<"robots" | "tasks" | "robot" | "task", number>> & { at?: Point };
type WorldEvent = Change & { step: number; sensing?: { miss?: number }; radio?: { loss?: number } };

// A field of the form, from form.py; slide: least, most and step of its slider.
type Field = {
  path: string;
  name: string;
  note?: string;
  kind: string;
  nullable?: boolean;
  choices?: string[];
  min?: number;
  max?: number | bigint;
  slide?: [number, number, number];
};
type FormState = { settings: Settings; set: Record<string, any> }; // set: what the user has changed, by path
type Replay = Record<"run" | "seed" | "decision", string> &
  Record<"point" | "decision_step", number> & { values: Record<string, string> };

// What theory says, by prediction.py; opinions: by step, of which the first is the mean share for feasible.
type Prediction = { text: string; opinions?: number[][] };

// Tasks, and classes of robots, from a step on; taken, if robots act: 0 for a free task, 1 taken, 2 done.
type There = { step: number; taken?: Uint16Array; kinds: number[] } & Record<
  "taskX" | "taskY" | "taskNumbers",
  Uint16Array
>;
type Columns = Record<"x" | "y" | "flags" | "aims", Uint16Array> & { heading: Uint8Array };
type Count = (typeof import("./history.js").NUMBERS)[number];

// A step of a swarm: places in 65,536ths of the arena's longer side; robots: number of numbers that robots may have; aims:
// the task of each robot, as its place among those shown; decision: 1, 0, or -1.
type Frame = There & Columns & Record<Count | "robots", number>;

// Some steps of a run, with the robots of each `every`th step; numbers: NUMBERS of each step.
type Steps = Record<"from" | "count" | "every" | "robots", number> & {
  numbers: ArrayLike<number>;
  there: There[];
  done: boolean;
  problem: string;
} & { [name in keyof Columns]?: ArrayLike<number> };

type Outcome = { decision: number; step: number; isRight: boolean; course: Uint16Array }; // course: robots for feasible, by step

// A robot as pages.c has it; counts: by class of robots, then of tasks; heard: id and opinion of each sender.
type Robot = Record<string, number> & {
  counts: number[];
  memory: number[];
  heard: [number, number][];
  problem?: string;
};

// The step that is shown; what comes next: at a step it has other flags, for so many steps or null if that isn't known; and
// the steps from which on a robot holds its opinion, and its phase lasts.
type Moment = {
  step: number;
  next: { step: number; flags: number; lasts: number | null } | null;
  since: { held: number; begun: number };
};
