// The workbench: tried models on the left, the robot in the middle, what can act at a place on the right.
import { choice, download, element } from "../dom.js";
import { forgetFigures } from "../figure.js";
import { measurementSection } from "../measurements.js";
import { workTable } from "../plans.js";
import { number } from "../units.js";
import { inPrint } from "../words.js";
import { cardList, comparisonTable } from "./cards.js";
import { effectList, effectsAt, otherPlaces, sliders } from "./effects_panel.js";
import { RobotView } from "./robot_view.js";
import { ask, follow, question, work } from "./server.js";

const movesRead = ["dx", "dy", "dz"];

/** What a model misses, an arrow a reading at its posture: [{at, by}]. */
function missed(columns, residual) {
  const measured = movesRead.filter((c) => residual[c]);
  if (!measured.length) return [];
  return columns.pose
    .map((pose, i) => ({
      at: columns.poses[pose].position,
      by: movesRead.map((c) => residual[c]?.[i] ?? 0),
    }))
    .filter(({ by }) => by.some((x) => x !== 0));
}

/** "1: q1 9.675, q2 -12.57", without the name of the chain where there is one. */
function postureName(poses, k) {
  const named = /([A-Za-z_]\w*)\.(?=[A-Za-z_])/g;
  const label = poses[k].label || "home";
  const chains = new Set(poses.flatMap((pose) => [...(pose.label ?? "").matchAll(named)].map((match) => match[1])));
  return `${k + 1}: ${chains.size === 1 ? label.replaceAll(named, "") : label}`;
}

/** The posture under the largest force is looked at first. */
function firstPosture({ pose, load }) {
  const size = (i) => Math.hypot(...["fx", "fy", "fz"].map((f) => load?.[f]?.[i] ?? 0));
  let best = 0;
  for (let i = 1; i < pose.length; ++i) if (size(i) > size(best)) best = i;
  return pose[best] ?? 0;
}

/** Other children, and the focus where it was: whoever uses the keyboard stays where they are. */
function refill(parent, ...children) {
  const at = parent.contains(document.activeElement) ? document.activeElement : null;
  parent.replaceChildren(...children);
  for (const key of ["id", "data-effect", "aria-label"]) {
    const name = at?.getAttribute(key);
    if (name) return parent.querySelector(`[${key}="${CSS.escape(name)}"]`)?.focus();
  }
  return undefined;
}

export class Bench {
  /** state: as the server has it; bar: shows jobs; close(): back to the start page; charts(): a promise that Plotly is there. */
  constructor(state, bar, close, charts) {
    this.project = state.project;
    this.notes = state.notes;
    this.bar = bar;
    this.charts = charts;
    const { readings } = this.project;
    const [nominal, fitted] = readings.models;
    this.residuals = new Map([
      ["nominal", nominal],
      ["fitted", fitted ?? nominal],
    ]);
    this.ticked = new Set();
    this.pose = firstPosture(readings);
    this.posture = question("posture");
    this.place = null;
    this.view = new RobotView((place) => this.select(place));
    this.headline = element("p", { class: "headline", role: "status", id: "studio-headline" });
    this.details = element("div", { class: "outcome" });
    this.left = element("aside", { class: "tried", "aria-label": "Tried models" });
    this.right = element("aside", { class: "acts", "aria-label": "What can act" });
    this.all = element("details", { class: "rest" }, element("summary", {}, "Every chart and test of these models"));
    this.all.addEventListener("toggle", () => this.drawCharts());
    const job = (text, name, act, kind) =>
      element("button", { type: "button", id: `studio-${name}`, class: kind, onclick: act }, text);
    this.tools = element(
      "div",
      { class: "bench-tools" },
      choice(
        "Posture",
        readings.poses.map((_, k) => [k, postureName(readings.poses, k)]),
        this.pose,
        (k) => {
          this.pose = Number(k);
          this.drawRobot();
        },
      ),
      element("span", { class: "grow" }),
      job("Diagnose", "diagnose", () => this.diagnose(), "primary"),
      job("Plan readings", "plan", () => this.plan()),
      job("Adopt model", "adopt", () => this.adopt()),
      job("Open other files", "close", close),
    );
    this.node = element(
      "div",
      { class: "bench" },
      this.tools,
      this.left,
      element("div", { class: "middle" }, this.headline, this.view.node, this.details),
      this.right,
      this.all,
      element(
        "p",
        { class: "say kept" },
        `${this.project.robot.name}; ${readings.pose.length} readings. Kept in ${this.project.folder}/studio.json.`,
      ),
    );
  }

  async start(running) {
    this.chosen = this.notes.chosen ?? "fitted";
    if (!this.models().some((m) => m.title === this.chosen)) this.chosen = "fitted";
    this.drawAll();
    if (running) await this.resume(running);
    if (!this.residuals.has(this.chosen)) await this.restore(this.model());
    else await this.drawRobot();
  }

  models() {
    return [
      { title: "nominal", fixed: true, card: this.project.nominal, names: null },
      { title: "fitted", fixed: true, card: this.project.fitted, names: [] },
      ...this.notes.cards.map((card) => ({
        title: card.name,
        card,
        names: card.effects.map((e) => e.name),
      })),
    ];
  }
  model() {
    return this.models().find((m) => m.title === this.chosen);
  }
  joints() {
    const skeleton = this.picture?.skeletons[0];
    return new Set(
      skeleton?.chains.flatMap((c) => c.joints.map((j) => `${c.name}.${j.name}`)) ?? [],
    );
  }

  /** Shows a job and takes its result; what goes wrong is said in words. */
  async run(name, body) {
    try {
      return await this.bar.during(() => work(name, body, (status) => this.bar.show(status)));
    } catch (error) {
      this.say(error.message === "stopped" ? "Stopped." : `Not done: ${error.message}`);
      return null;
    }
  }
  async resume(status) {
    try {
      const result = await this.bar.during(() => follow((s) => this.bar.show(s)));
      await this.refreshNotes();
      if (status.job === "fit") this.take(result);
    } catch (error) {
      this.say(error.message);
    }
    this.drawAll();
  }
  async refreshNotes() {
    this.notes = (await ask("state")).notes;
  }
  say(text) {
    this.headline.textContent = inPrint(text);
  }

  take({ card, model }) {
    const title = card.name || "fitted";
    this.residuals.set(title, model);
    this.chosen = title;
  }
  async fit(names) {
    const result = await this.run("fit", { effects: names });
    if (!result) return;
    await this.refreshNotes();
    this.take(result);
    this.drawAll();
    await this.drawRobot();
  }
  async restore(model) {
    if (model.names && !this.residuals.has(model.title)) return this.fit(model.names);
    this.chosen = model.title;
    this.drawAll();
    await this.drawRobot();
  }
  toggle(effect) {
    const now = this.model().names ?? [];
    return this.fit(
      now.includes(effect.name)
        ? now.filter((name) => name !== effect.name)
        : [...now, effect.name],
    );
  }
  async remove(model) {
    this.notes = await ask("remove", { name: model.title });
    this.ticked.delete(model.title);
    if (this.chosen === model.title) await this.restore(this.models()[1]);
    else this.drawAll();
  }

  async diagnose() {
    const verdict = await this.run("diagnose", {});
    if (!verdict) return;
    await this.refreshNotes();
    const name = verdict.found.join(" + ");
    const found = this.models().find((m) => m.title === name);
    this.drawAll();
    if (found) await this.restore(found);
    this.say(verdict.headline);
  }
  async plan() {
    const plan = await this.run("plan", {});
    if (!plan) return;
    await this.refreshNotes();
    this.drawAll();
    this.say(plan.headline);
  }
  async adopt() {
    const file = this.fileName.value;
    const adopted = await this.run("adopt", { effects: this.model().names ?? [], file });
    if (!adopted) return;
    await this.refreshNotes();
    this.drawAll();
    this.say(`Wrote ${adopted.file}. ${adopted.headline}`);
  }

  select(place) {
    this.place = place;
    this.drawEffects();
    this.view.mark({ selected: place, active: this.activePlaces() });
  }
  activePlaces() {
    const names = this.model().names ?? [];
    return this.project.effects.filter((e) => names.includes(e.name)).flatMap((e) => e.places);
  }

  drawAll() {
    const model = this.model();
    const models = this.models();
    refill(
      this.left,
      element("h2", {}, "Tried models"),
      element("p", { class: "say" }, "Error in times the noise; dashed: 1."),
      cardList(models, models.indexOf(models.find((m) => m.title === this.chosen)), this.ticked, {
        restore: (m) => this.restore(m),
        remove: (m) => this.remove(m),
        tick: (m, is) => {
          if (is) this.ticked.add(m.title);
          else this.ticked.delete(m.title);
          this.drawAll();
        },
      }),
      element("p", { class: "say" }, "Tick two models to compare them."),
    );
    this.say(
      `Model ${model.title.replaceAll("_", " ")}: error ${number(model.card.error)} times the noise, ${model.card.degrees_of_freedom} degrees of freedom.`,
    );
    this.drawOutcome();
    this.drawEffects();
    this.drawCharts();
    this.view.mark({ selected: this.place, active: this.activePlaces() });
  }

  drawOutcome() {
    const { verdict, plan, adopted } = this.notes;
    const parts = [];
    const two = this.models().filter((m) => this.ticked.has(m.title));
    if (two.length === 2) parts.push(element("div", { id: "studio-compared" }, comparisonTable(...two)));
    if (verdict) {
      parts.push(element("h2", {}, "Verdict"), element("p", { id: "studio-verdict" }, inPrint(verdict.headline)));
      if (verdict.excluded.length)
        parts.push(element("p", { class: "say" }, `Not it: ${verdict.excluded.map((e) => `${e.effect} (${e.odds})`).join(", ")}.`));
      if (verdict.not_observable.length)
        parts.push(element("p", { class: "say" }, `Not observable in these readings: ${verdict.not_observable.join(", ")}.`));
    }
    if (plan) {
      parts.push(element("h2", {}, "Readings to take next"), element("p", {}, inPrint(plan.headline)));
      const work = workTable(plan.work_list);
      if (work) parts.push(work);
      if (plan.text) parts.push(this.downloadButton(plan.file, plan.text));
    }
    if (adopted)
      parts.push(
        element("h2", {}, "Adopted"),
        element("p", { id: "studio-adopted" }, `${adopted.file}: error ${number(adopted.error)} times the noise as it is written.`),
        this.downloadButton(adopted.file, adopted.text),
      );
    this.details.replaceChildren(...parts);
  }
  downloadButton(file, text) {
    return element(
      "button",
      { type: "button", onclick: () => download(file, "text/plain", text) },
      `Download ${file}`,
    );
  }

  drawEffects() {
    const { effects } = this.project;
    const model = this.model();
    const joints = this.joints();
    const others = otherPlaces(effects, joints);
    const all = [...[...joints].filter((j) => effectsAt(effects, j).length).map((j) => [j, `joint ${j}`]), ...others];
    const here = this.place ? effectsAt(effects, this.place) : [];
    const title = all.find(([place]) => place === this.place)?.[1];
    const parts = [
      element("h2", {}, title ? `What can act: ${title}` : "What can act"),
      this.placeChoice(all),
      effectList(here, model.names ?? [], this.notes.verdict?.probabilities, (e) => this.toggle(e)),
    ];
    if (!this.place)
      parts.push(element("p", { class: "say" }, "Each effect is a law of physics that can act at one place: play, friction, a soft bearing. Add one to the model, and see whether the error falls."));
    if (this.place && !here.length)
      parts.push(element("p", { class: "say" }, "No effect of the catalogue acts here."));
    if (model.card.effects.length)
      parts.unshift(
        element("h2", {}, "Values in the model"),
        sliders(model.card, effects, (values) => this.tryValues(values)),
        element("p", { class: "say", role: "status", id: "studio-tried" }, `Best values: error ${number(model.card.error)}.`),
        element("button", { type: "button", onclick: () => this.restore(model) }, "Back to the best values"),
      );
    this.fileName = this.fileName ?? element("input", { type: "text", id: "studio-file", value: "calibrated.yaml", size: "18" });
    parts.push(element("p", {}, element("label", {}, "Robot file that Adopt writes ", this.fileName)));
    refill(this.right, ...parts);
  }

  placeChoice(places) {
    const options = [["", "choose, or click a joint"], ...places];
    const node = choice("Place", options, this.place ?? "", (place) => this.select(place || null));
    node.querySelector("select").id = "studio-place";
    return node;
  }

  /** One request at a time, the last values win. */
  async tryValues(values) {
    this.wanted = values;
    if (this.trying) return;
    this.trying = true;
    const model = this.model();
    try {
      while (this.wanted) {
        const now = this.wanted;
        this.wanted = null;
        const { error, model: tried } = await ask("try", { effects: model.names, values: now });
        const status = document.getElementById("studio-tried");
        if (status)
          status.textContent = `By hand: error ${number(error)} (best ${number(model.card.error)}).`;
        this.drawErrors(tried);
      }
    } catch (error) {
      const status = document.getElementById("studio-tried");
      if (status) status.textContent = error.message;
    }
    this.trying = false;
  }

  drawErrors(columns) {
    if (!this.picture) return;
    this.view.show({ ...this.picture, errors: missed(this.project.readings, columns.residual) });
  }
  async drawRobot() {
    try {
      const picture = await this.posture({ pose: this.pose, effects: this.model().names ?? [] });
      if (picture === undefined) return;
      const isFirst = !this.picture; // which tells the joints
      if (picture) this.picture = picture;
      if (isFirst) this.drawEffects();
      this.drawErrors(this.residuals.get(this.chosen) ?? this.residuals.get("fitted"));
      this.node.dataset.drawn = String(performance.now());
    } catch (error) {
      this.say(error.message);
    }
  }

  async drawCharts() {
    forgetFigures(this.all);
    this.all.replaceChildren(this.all.firstChild);
    if (!this.all.open) return;
    await this.charts();
    const { readings, result } = this.project;
    const shown = this.residuals.get(this.chosen);
    const models = readings.models.includes(shown) || !shown ? readings.models : [...readings.models, shown];
    this.all.replaceChildren(
      this.all.firstChild,
      measurementSection({
        name: this.project.robot.name,
        comparison: result,
        columns: { ...readings, models },
        switched: readings.models.includes(shown) ? undefined : this.chosen,
      }),
    );
  }
}
