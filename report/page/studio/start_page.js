// The start page: an example, files of one's own, or files to start with; how the columns of a table are understood.
import { choice, element } from "../dom.js";
import { number } from "../units.js";
import { ask, question } from "./server.js";

async function base64Of(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  let text = "";
  for (let k = 0; k < bytes.length; k += 0x8000)
    text += String.fromCharCode(...bytes.subarray(k, k + 0x8000));
  return btoa(text);
}

const valuesInWords = ({ values, range, missing }) =>
  [
    range ? (range[0] === range[1] ? number(range[0]) : `${number(range[0])} to ${number(range[1])}`) : `${values} cells`,
    missing ? `${missing} missing` : "",
  ]
    .filter(Boolean)
    .join("; ");

const lacksUnit = ({ what }) => what.endsWith("has no unit");
/** All columns whose unit nobody stated, in one sentence. */
function withoutUnit(mistakes) {
  const names = mistakes.filter(lacksUnit).map(({ key }) => key);
  if (!names.length) return [];
  const words = `${names.length} column${names.length > 1 ? "s have" : " has"} no unit: ${names.join(", ")}. State it above, for all at once or in the line of a column.`;
  return [element("p", { class: "mistake" }, words)];
}

export class StartPage {
  /** open(what): opens a demo or files. */
  constructor(state, open) {
    this.state = state;
    this.open = open;
    this.asked = { columns: {}, units: {} };
    this.readings = question("readings");
    this.status = element("p", { role: "status", id: "start-status" });
    this.columns = element("div", { id: "start-columns" });
    this.chosen = element("div", {});
    this.node = element("div", { class: "start" });
    this.draw();
  }

  draw() {
    this.node.replaceChildren(
      element("p", { class: "lead" }, "Which effect does the model of a robot lack? Open a robot and its readings, and see."),
      element(
        "div",
        { class: "doors" },
        this.exampleDoor(),
        this.ownDoor(),
        this.newDoor(),
      ),
      this.status,
      this.columns,
    );
  }

  door(title, ...inside) {
    return element("section", { class: "door" }, element("h2", {}, title), ...inside);
  }
  exampleDoor() {
    return this.door(
      "Look at an example",
      ...this.state.demos.map(({ name, sentence }) =>
        element(
          "button",
          { type: "button", class: "demo", "data-demo": name, onclick: () => this.open({ demo: name }) },
          element("b", {}, `Open ${name}`),
          element("span", {}, sentence),
        ),
      ),
    );
  }
  ownDoor() {
    const input = element("input", {
      type: "file",
      id: "start-files",
      multiple: true,
      accept: ".csv,.tsv,.txt,.xlsx,.ods,.yaml,.yml",
      onchange: (event) => this.drop(event.target.files),
    });
    const zone = element(
      "div",
      {
        class: "drop",
        ondragover: (event) => {
          event.preventDefault();
          zone.classList.add("over");
        },
        ondragleave: () => zone.classList.remove("over"),
        ondrop: (event) => {
          event.preventDefault();
          zone.classList.remove("over");
          this.drop(event.dataTransfer.files);
        },
      },
      element("label", { for: "start-files" }, "Drop a robot file (.yaml) and a table of readings (CSV, XLSX, ODS) here, or choose them:"),
      input,
    );
    this.fillChosen();
    return this.door("Open your own files", zone, this.chosen);
  }
  newDoor() {
    return this.door(
      "Start a new robot",
      element("p", { class: "say" }, `Writes a commented robot file, a campaign file and readings into ${this.state.folder}, to change into your own.`),
      element("button", { type: "button", id: "start-new", onclick: () => this.starters() }, "Write files to start with"),
    );
  }

  fillChosen() {
    const { robots, campaigns, tables } = this.state.files;
    const pick = (label, names, key) => {
      if (!names.length) return null;
      const node = choice(label, [["", "-"], ...names.map((n) => [n, n])], this.asked[key] ?? "", (name) => {
        this.asked[key] = name || undefined;
        if (key === "table") Object.assign(this.asked, { columns: {}, units: {}, sheet: undefined });
        this.look();
      });
      node.querySelector("select").id = `start-${key}`;
      return element("p", {}, node);
    };
    const openCampaign = campaigns.length
      ? element(
          "p",
          {},
          ...campaigns.map((name) =>
            element(
              "button",
              { type: "button", "data-campaign": name, onclick: () => this.open({ campaign: name, ...(this.asked.robot ? { robot: this.asked.robot } : {}) }) },
              `Open ${name}`,
            ),
          ),
        )
      : null;
    this.chosen.replaceChildren(
      ...[pick("Robot file", robots, "robot"), pick("Table of readings", tables, "table"), openCampaign].filter(Boolean),
    );
  }

  async guarded(act) {
    this.status.textContent = "";
    try {
      await act();
    } catch (error) {
      this.status.textContent = error.message;
    }
  }
  drop(files) {
    return this.guarded(async () => {
      const said = [];
      for (const file of files) {
        const { file: name, kind } = await ask("drop", { name: file.name, content: await base64Of(file) });
        said.push(`${name} is ${kind}`);
        if (kind === "a robot file") this.asked.robot = name;
        if (/^a table/.test(kind)) this.asked = { ...this.asked, table: name, columns: {}, units: {} };
      }
      this.state.files = (await ask("state")).files;
      this.fillChosen();
      this.status.textContent = `${said.join(". ")}.`;
      await this.look();
    });
  }
  starters() {
    return this.guarded(async () => this.open(await ask("new")));
  }
  look() {
    return this.guarded(async () => {
      if (!this.asked.table) return this.columns.replaceChildren();
      const overview = await this.readings(this.asked);
      if (!overview || !this.asked.table) return;
      this.overview = overview;
      this.fillColumns();
    });
  }

  fillColumns() {
    const { columns, meanings, notes, mistakes, rows, readings } = this.overview;
    const mapped = (column) => {
      const stated = this.asked.columns[column.column];
      return choice(
        `Meaning of ${column.column}`,
        [["", stated ? "as guessed" : column.words], ...meanings.map((m) => [m, m])],
        stated?.replace(/^-/, "").replace(/ \[.*/, "") ?? "",
        (meaning) => this.mapColumn(column, meaning),
      );
    };
    const unit = (column) =>
      element("input", {
        type: "text",
        size: "6",
        value: this.asked.columns[column.column]?.match(/\[(.*)\]/)?.[1] ?? "",
        placeholder: column.unit,
        "aria-label": `Unit of ${column.column}`,
        onchange: (event) => this.mapColumn(column, column.meaning, event.target.value),
      });
    const row = (column) =>
      element(
        "tr",
        { class: column.looks_like ? "doubtful" : undefined },
        element("th", { scope: "row" }, column.column),
        element("td", {}, `${column.negative ? "minus " : ""}${column.words}`),
        element("td", { class: "map" }, mapped(column)),
        element("td", {}, unit(column)),
        element("td", { class: "number" }, valuesInWords(column)),
      );
    this.noise = this.noise ?? element("input", { type: "text", size: "8", id: "start-noise", placeholder: "2 um" });
    this.columns.replaceChildren(
      element("h2", {}, `${readings}: ${rows} readings`),
      element(
        "div",
        { class: "scroll columns", tabindex: "0", role: "group", "aria-label": "How each column is understood" },
        element(
          "table",
          {},
          element("caption", {}, "How each column is understood; change what is not right"),
          element("thead", {}, element("tr", {}, ...["column", "understood as", "change to", "unit", "values"].map((t) => element("th", { scope: "col" }, t)))),
          element("tbody", {}, ...columns.map(row)),
        ),
      ),
      this.tableOptions(),
      ...notes.map((note) => element("p", { class: "say" }, note)),
      ...withoutUnit(mistakes),
      ...mistakes.filter((m) => !lacksUnit(m)).map((m) => element("p", { class: "mistake" }, `${m.line ? `Line ${m.line}: ` : ""}${m.key ? `${m.key}: ` : ""}${m.what}${m.cure ? `. ${m.cure}.` : ""}`)),
      element("p", {}, element("label", {}, "Noise of a translation, where readings are not repeated ", this.noise)),
      element(
        "button",
        { type: "button", class: "primary", id: "start-use", disabled: mistakes.length > 0 || !this.asked.robot, onclick: () => this.use() },
        "Use these readings",
      ),
      this.asked.robot ? "" : element("p", { class: "say" }, "A robot file is missing: drop one, too."),
    );
  }
  tableOptions() {
    const set = (change) => {
      Object.assign(this.asked, change);
      return this.look();
    };
    const units = (key, list) => {
      const label = `${key[0].toUpperCase()}${key.slice(1)}s without a unit are in`;
      const options = [["", "not stated"], ...list.map((u) => [u, u])];
      const node = choice(label, options, this.asked.units[key] ?? "", (u) =>
        set({ units: { ...this.asked.units, [key]: u } }),
      );
      node.querySelector("select").id = `start-${key}`;
      return node;
    };
    return element(
      "div",
      { class: "table-options" },
      units("length", ["um", "mm", "m"]),
      units("force", ["N", "kN"]),
      units("angle", ["deg", "rad"]),
      units("time", ["s", "min", "h"]),
      choice("Displacements are", [["", "differences from the unloaded state"], ["absolute", "poses in the base frame"]], this.asked.displacement ?? "", (d) =>
        set({ displacement: d || undefined }),
      ),
    );
  }
  mapColumn(column, meaning, unit) {
    const columns = { ...this.asked.columns };
    if (!meaning) delete columns[column.column];
    else columns[column.column] = unit ? `${meaning} [${unit}]` : meaning;
    this.asked.columns = columns;
    return this.look();
  }
  use() {
    return this.guarded(async () => {
      const { campaign } = await ask("use", { ...this.asked, noise: this.noise.value });
      await this.open({ campaign, robot: this.asked.robot });
    });
  }
}
