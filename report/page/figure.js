// One chart with all that belongs to it: what it shows in words, unit, n and source; saving as PNG, SVG and CSV.
import { download, element, table } from "./dom.js";
import { framed, look } from "./look.js";

const figures = [];

// Several results of one kind on a page: "path", "path-2", ...
function unused(id) {
  const taken = (name) => figures.some((figure) => figure.spec.id === name);
  let name = id;
  for (let k = 2; taken(name); ++k) name = `${id}-${k}`;
  return name;
}
const shownRows = 300;
const csvCell = (value) => {
  const text = value === null || value === undefined || Number.isNaN(value) ? "" : String(value);
  return /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
};

/**
 * spec: id, title, say (what the chart shows, in a sentence), source; draw(look, narrow) -> {data, layout}; numbers() ->
 * {columns, rows}; n (or what gives it); height [px]; tall: height where the page is narrow; paper: height in print; least: least width [px]; wide; heavy (drawn by WebGL: let go when out of sight); follows (keys of the view
 * that it depends on); choose(point): what a click means; step(by): what the arrow keys mean; controls: elements above.
 */
export class Figure {
  constructor(spec, view) {
    this.spec = { ...spec, id: unused(spec.id) };
    spec = this.spec;
    this.view = view;
    this.drawn = false;
    this.plot = element("div", {
      class: "plot",
      role: "group",
      tabindex: "0",
      "aria-label": `${spec.title}. ${spec.say}`,
      style: `height:${spec.height ?? 360}px;min-width:${spec.least ?? 0}px`,
      onkeydown: (event) => this.key(event),
    });
    this.caption = element("figcaption");
    this.count();
    this.node = element(
      "figure",
      { id: spec.id, class: spec.wide ? "wide" : spec.least ? "roomy" : undefined },
      element("h3", {}, spec.title),
      element("p", { class: "say" }, spec.say),
      ...(spec.controls ?? []),
      element("div", { class: "room" }, this.plot),
      this.caption,
      element(
        "div",
        { class: "save" },
        ...["png", "svg"].map((format) =>
          element(
            "button",
            {
              type: "button",
              "aria-label": `Save ${spec.title} as ${format.toUpperCase()}`,
              onclick: () => this.save(format),
            },
            format.toUpperCase(),
          ),
        ),
        element(
          "button",
          {
            type: "button",
            "aria-label": `Save the numbers of ${spec.title} as CSV`,
            onclick: () => this.csv(),
          },
          "CSV",
        ),
        this.details(),
      ),
    );
    figures.push(this);
    if (view)
      view.listen((keys) => {
        if (keys.some((key) => (spec.follows ?? []).includes(key))) this.refresh();
      });
    watcher.observe(this.node);
    this.node.figure = this;
  }

  count() {
    const { n, source } = this.spec;
    this.caption.textContent = `n = ${typeof n === "function" ? n() : n}. ${source}`;
  }

  details() {
    const node = element("details", {}, element("summary", {}, "Numbers"));
    node.addEventListener("toggle", () => {
      if (!node.open) return;
      const { columns, rows } = this.spec.numbers();
      const cut =
        rows.length > shownRows
          ? `, the first ${shownRows} of ${rows.length} rows (CSV has all)`
          : "";
      const short = (v) => (typeof v === "number" ? Number(v.toPrecision(5)) : (v ?? ""));
      node.replaceChildren(
        node.firstChild,
        table(
          columns,
          rows.slice(0, shownRows).map((row) => row.map(short)),
          `${this.spec.title}${cut}`,
        ),
      );
    });
    return node;
  }

  draw() {
    const narrow = this.node.clientWidth < 600;
    this.plot.style.height = `${(narrow && this.spec.tall) || (this.spec.height ?? 360)}px`;
    const { data, layout } = this.spec.draw(look(), narrow);
    if (layout.scene) layout.scene = framed(layout.scene, data);
    if (narrow && layout.scene) for (const k of ["x", "y", "z"]) layout.scene.camera.eye[k] *= 1.5;
    const config = {
      displaylogo: false,
      displayModeBar: narrow ? false : "hover",
      responsive: true,
      modeBarButtonsToRemove: ["lasso2d", "select2d", "toImage", "resetCameraLastSave3d"],
    };
    Plotly.react(this.plot, data, { ...layout, autosize: true }, config);
    if (!this.drawn && this.spec.choose)
      this.plot.on("plotly_click", (event) => this.spec.choose(event.points[0]));
    this.drawn = true;
    // Plotly calls every solid scene the same.
    for (const node of this.plot.querySelectorAll("#scene")) node.removeAttribute("id");
    this.plot
      .querySelector(".modebar")
      ?.setAttribute("aria-label", `Zoom and move: ${this.spec.title}`);
    this.count();
    this.node.dataset.points = String(data.reduce((total, trace) => total + pointsOf(trace), 0));
  }

  refresh() {
    if (this.inSight) this.draw();
    else this.stale = true;
  }

  sight(visible) {
    this.inSight = visible;
    if (visible && (!this.drawn || this.stale)) {
      this.stale = false;
      this.draw();
    }
    if (!visible && this.drawn && this.spec.heavy) {
      Plotly.purge(this.plot);
      this.drawn = false;
    }
  }

  toPaper() {
    if (this.spec.paper) this.plot.style.height = `${this.spec.paper}px`;
    this.draw();
    for (const name of this.plot._fullLayout._subplots.gl3d ?? []) {
      // What WebGL draws is on the screen only later, and not at all where too many do.
      const { _scene: scene } = this.plot._fullLayout[name];
      scene.container.append(element("img", { class: "still", alt: "", src: scene.toImage("png") }));
    }
  }

  toScreen() {
    if (this.spec.paper) this.plot.style.height = `${this.spec.height}px`;
    const inSight = this.inSight;
    this.sight(false);
    if (this.drawn && inSight) this.draw();
    else if (inSight) this.sight(true);
    else this.stale = true;
    this.inSight = inSight;
  }

  key(event) {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by || !this.spec.step) return;
    event.preventDefault();
    this.spec.step(by);
  }

  async save(format) {
    this.inSight = true;
    if (!this.drawn) this.draw();
    await Plotly.downloadImage(this.plot, {
      format,
      filename: `kinetostat-${this.spec.id}`,
      scale: format === "png" ? 2 : 1,
      width: this.plot.clientWidth,
      height: this.plot.clientHeight,
    });
  }

  csv() {
    const { columns, rows } = this.spec.numbers();
    const text = [
      `# ${this.spec.title}; ${this.spec.source}`,
      ...[columns, ...rows].map((row) => row.map(csvCell).join(",")),
    ].join("\n");
    download(`kinetostat-${this.spec.id}.csv`, "text/csv", `${text}\n`);
  }
}

function pointsOf(trace) {
  if (trace.meta === "guide") return 0;
  const values =
    trace.z && Array.isArray(trace.z[0])
      ? trace.z.flat()
      : trace.type === "bar" && trace.orientation === "h"
        ? trace.y
        : (trace.x ?? trace.y ?? []);
  return values.filter((value) => value !== null && value !== undefined && !Number.isNaN(value))
    .length;
}

// Charts are drawn when they come near, so that a page with many opens at once.
const watcher = new IntersectionObserver(
  (entries) => {
    for (const entry of entries) entry.target.figure.sight(entry.isIntersecting);
  },
  { rootMargin: "300px" },
);

/** Lets go of the charts in a part of the page that is about to be replaced. */
export function forgetFigures(parent) {
  for (const node of parent.querySelectorAll("figure")) {
    watcher.unobserve(node);
    if (node.figure.drawn) Plotly.purge(node.figure.plot);
    figures.splice(figures.indexOf(node.figure), 1);
  }
}

/** All charts in light colours and as wide as paper, while the browser prints: it asks once, and does not wait. */
let screenTheme = null;
function toPaper() {
  const root = document.documentElement;
  screenTheme = root.dataset.theme ?? "";
  root.dataset.theme = "light";
  root.classList.add("printing");
  for (const rest of document.querySelectorAll("details.rest")) rest.open = true;
  for (const figure of figures) figure.toPaper();
}
function toScreen() {
  const root = document.documentElement;
  root.classList.remove("printing");
  if (screenTheme) root.dataset.theme = screenTheme;
  else delete root.dataset.theme;
  for (const figure of figures) figure.toScreen();
}
addEventListener("beforeprint", toPaper);
addEventListener("afterprint", toScreen);

export function redrawAll() {
  for (const figure of figures) if (figure.drawn) figure.refresh();
}
// A phone that is turned, a window that is made narrow.
matchMedia("(max-width: 640px)").addEventListener("change", () => requestAnimationFrame(redrawAll));
