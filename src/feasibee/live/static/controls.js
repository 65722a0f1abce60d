// The form of settings: what has been changed, and what the server says of it.

export class Controls {
  // change(changes, which): somebody changed something; which is {seed, run}, as text
  constructor(form, change) {
    this.form = form;
    this.change = change;
    this.changes = {};
    this.inputs = new Map();
    for (const input of form.querySelectorAll("[data-path]")) {
      this.inputs.set(input.dataset.path, input);
      const note = document.createElement("span");
      note.className = "note";
      note.id = `note-${input.dataset.path.replace(".", "-")}`;
      note.hidden = true;
      input.setAttribute("aria-describedby", note.id);
      input.closest("label").append(note);
      input.note = note;
    }
    form.addEventListener("change", (event) => event.target.dataset.path && this.changed(event.target));
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  get which() {
    return { seed: this.inputs.get("seed").value.trim(), run: this.inputs.get("run").value.trim() };
  }

  changed(input) {
    const { path } = input.dataset;
    if (path.includes(".")) this.changes[path] = this.valueOf(input);
    this.change();
  }

  valueOf(input) {
    if (input.type === "checkbox") return input.checked;
    if (input.type !== "number") return input.value;
    return Number.isNaN(input.valueAsNumber) ? input.value : input.valueAsNumber;
  }

  strategies(names) {
    this.inputs.get("decision.strategy").replaceChildren(...names.map((name) => new Option(name, name)));
  }

  // Show a swarm that has begun.
  show({ fields, seed, run }) {
    this.forgive();
    const values = { seed, run, ...fields };
    for (const [path, input] of this.inputs) {
      const value = values[path];
      if (
        value === undefined ||
        (input === document.activeElement && String(this.valueOf(input)) === String(value))
      )
        continue;
      if (input.type === "checkbox") input.checked = value;
      else input.value = value;
    }
  }

  forgive() {
    for (const input of this.inputs.values()) {
      input.removeAttribute("aria-invalid");
      input.note.hidden = true;
    }
    this.general("");
  }

  // Show what is wrong, each by its control if there is one.
  refuse(problems) {
    this.forgive();
    const others = [];
    for (const { path, text } of problems) {
      const input = this.inputs.get(path);
      if (!input) {
        others.push(text);
        continue;
      }
      input.setAttribute("aria-invalid", "true");
      input.note.textContent = text;
      input.note.hidden = false;
      for (let above = input.closest("details"); above; above = above.parentElement.closest("details"))
        above.open = true;
    }
    const more = problems.length > others.length ? ["Not changed; the swarm before goes on."] : [];
    this.general([...others, ...more].join("\n"));
  }

  general(text) {
    const place = this.form.querySelector("#problem");
    place.textContent = text;
    place.hidden = !text;
  }
}
