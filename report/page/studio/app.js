// The studio: its start page until a robot and readings are open, then the workbench.
import { element } from "../dom.js";
import { forgetFigures } from "../figure.js";
import { number } from "../units.js";
import { Bench } from "./bench.js";
import { ask, follow, stopWork, work } from "./server.js";
import { StartPage } from "./start_page.js";

const inWords = {
  open: "Opening",
  fit: "Fitting",
  diagnose: "Diagnosing",
  plan: "Planning readings",
  adopt: "Writing and comparing again",
};

/** What runs, how far it is, what it has found so far, and the button that stops it. */
class JobBar {
  constructor() {
    this.text = element("span", { role: "status", id: "studio-job" });
    this.progress = element("progress", { max: "1", "aria-label": "How far the work is" });
    this.found = element("ul", { class: "found", "aria-live": "polite" });
    this.stop = element("button", { type: "button", id: "studio-stop", onclick: () => stopWork() }, "Stop");
    this.node = element("div", { class: "job", hidden: true }, this.text, this.progress, this.stop, this.found);
  }
  show({ job, phase, fraction, seconds, found = [] }) {
    this.text.textContent = `${inWords[job] ?? job ?? ""}${phase ? `: ${phase}` : ""}, ${number(seconds ?? 0, 2)} s`;
    if (fraction > 0) this.progress.value = fraction;
    else this.progress.removeAttribute("value");
    if (found.length !== this.found.children.length)
      this.found.replaceChildren(...found.map((text) => element("li", {}, text.trim())));
  }
  /** Nothing else is started while work runs. */
  async during(act) {
    this.node.hidden = false;
    document.body.classList.add("busy");
    try {
      return await act();
    } finally {
      this.node.hidden = true;
      document.body.classList.remove("busy");
    }
  }
}

/** Fills the page; `charts()`: a promise that Plotly is there. */
export async function startStudio(page, charts) {
  const bar = new JobBar();
  const place = element("div", {});
  page.replaceChildren(bar.node, place);
  const title = (text) => {
    document.querySelector("h1").textContent = text;
    document.title = text;
  };

  async function showStart(message = "") {
    title("Studio");
    const start = new StartPage(await ask("state"), open);
    forgetFigures(place);
    place.replaceChildren(start.node);
    start.status.textContent = message;
  }
  async function showBench(state, running) {
    const close = async () => {
      await ask("close");
      await showStart();
    };
    const bench = new Bench(state, bar, close, charts);
    title(state.project.robot.name);
    forgetFigures(place);
    place.replaceChildren(bench.node);
    await bench.start(running);
  }
  async function opened(act) {
    try {
      await bar.during(act);
      await showBench(await ask("state"));
    } catch (error) {
      await showStart(error.message);
    }
  }
  const show = (status) => bar.show(status);
  const open = (what) => opened(() => work("open", what, show));

  const status = await ask("progress");
  if (status.running && status.job === "open") return opened(() => follow(show));
  if (status.running) {
    // The state is there when the work is done.
    try {
      await bar.during(() => follow(show));
    } catch {
      // It was stopped, or failed: the workbench shows what there is.
    }
  }
  const state = await ask("state");
  if (state.project) return showBench(state);
  if (state.given) return open({});
  return showStart();
}
