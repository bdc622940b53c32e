// Charts with one mark a reading: parity, residual against load, four-plot. They share how marks look and link.
import { plain } from "./dom.js";
import { axis, layout } from "./look.js";
import { deviation, groups, largest, mean, normalQuantile } from "./numbers.js";
import { kindOf, number, unitFor } from "./units.js";

const many = 3000;  // more marks than that are drawn by WebGL

export const scatterType = (count) => (count > many ? "scattergl" : "scatter");

/** Traces of marks: fitted, kept out, and those of the chosen pose on top. `place(i)`: [x, y]. */
export function marks(readings, view, look, indices, place, more = {}) {
  const chosen = view.get("pose");
  const symbols = (i) => (readings.branch[i] === 2 ? "triangle-down-open" : readings.branch[i] === 1 ? "triangle-up" : "circle");
  const trace = (name, members, color, size, symbol) => ({
    type: scatterType(indices.length), mode: "markers", name, x: members.map((i) => place(i)[0]), y: members.map((i) => place(i)[1]), customdata: members,
    text: members.map((i) => plain(readings.text(i))), hovertemplate: "%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>",
    marker: { color, size, opacity: members.length > many ? 0.5 : 0.85, symbol: symbol ?? (more.branches ? members.map(symbols) : "circle") }, ...more.trace,
  });
  const fitted = indices.filter((i) => !readings.heldOut(i));
  const held = indices.filter((i) => readings.heldOut(i));
  const traces = [trace("fitted", fitted, look.refitted, 5)];
  if (held.length) traces.push(trace("kept out", held, look.held, 6));
  const selected = indices.filter((i) => readings.pose[i] === chosen);
  traces.push({ ...trace("chosen pose", selected, look.chosen, 9, "circle-open"), meta: "guide", visible: chosen !== null });
  return traces;
}

export const choosing = (readings, view) => ({
  choose: (point) => { if (point.customdata !== undefined) view.set({ pose: readings.pose[point.customdata] }); },
  step: (by) => {
    const count = readings.poses.length;
    const pose = view.get("pose");
    view.set({ pose: pose === null ? 0 : (pose + by + count) % count });
  },
});

const scaleOf = (readings, component, value) => unitFor(kindOf(component), largest(readings.models.flatMap((_, m) => readings.used(component).map((i) => value(m, i)))));

// A range over all models, so that axes stay when the model changes.
function sameRange(readings, component, factor) {
  const most = 1.05 * largest(readings.models.flatMap((_, m) => readings.used(component).map((i) => readings.residual(m, component, i)))) / factor;
  return [-most, most];
}

const band = (look, half, orientation = "y") => (half ? [{ type: "rect", layer: "below", [orientation === "y" ? "xref" : "yref"]: "paper",
  ...(orientation === "y" ? { x0: 0, x1: 1, y0: -half, y1: half } : { y0: 0, y1: 1, x0: -half, x1: half }), fillcolor: look.noise, opacity: 0.22, line: { width: 0 } }] : []);

export function parity(readings, view, source) {
  const rows = (component, model) => readings.used(component).map((i) => {
    const measured = readings.measured[component][i];
    return [readings.id[i], readings.heldOut(i) ? "kept out" : "fitted", measured - readings.residual(model, component, i), measured];
  });
  return {
    id: "parity", title: "Measured against predicted", n: readings.used(readings.components[0]).length, source, heavy: readings.count > many,
    follows: ["component", "model", "pose"], ...choosing(readings, view),
    say: "On the line the model is right; the grey band is twice the noise, and may be too narrow to see.",
    numbers: () => ({ columns: ["reading", "role", "predicted [m or rad]", "measured [m or rad]"], rows: rows(view.get("component"), view.get("model")) }),
    draw(look) {
      const component = view.get("component");
      const model = view.get("model");
      const used = readings.used(component);
      const { factor, unit } = unitFor(kindOf(component), largest(used.map((i) => readings.measured[component][i])));
      const most = (1.05 * largest(used.map((i) => readings.measured[component][i]))) / factor;
      const half = (2 * (readings.noiseOf(component) ?? 0)) / factor;
      const line = (shift, name, fill) => ({ type: "scatter", mode: "lines", meta: "guide", name, x: [-most, most], y: [-most + shift, most + shift], hoverinfo: "skip", showlegend: fill === undefined && shift === 0,
        line: { color: shift === 0 ? look.quiet : look.noise, width: shift === 0 ? 1 : 0 }, ...(fill ? { fill, fillcolor: `${look.noise}55` } : {}) });
      const place = (i) => { const m = readings.measured[component][i]; return [(m - readings.residual(model, component, i)) / factor, m / factor]; };
      return {
        data: [line(-half, "", undefined), line(half, "noise", "tonexty"), line(0, "equal"), ...marks(readings, view, look, used, place)].map((t, k) => (k === 0 ? { ...t, showlegend: false } : t)),
        layout: layout(look, { xaxis: axis(look, `predicted ${component} [${unit}]`), yaxis: axis(look, `measured ${component} [${unit}]`) }),
      };
    },
  };
}

/** The axis of load that most readings have, and readings along it. */
function loadAxis(readings, view, component) {
  const used = readings.used(component).filter((i) => view.get("pose") === null || readings.pose[i] === view.get("pose"));
  const counts = readings.loads.map((name) => [name, used.filter((i) => ["+", "-"].some((s) => readings.direction(i) === s + name)).length]);
  const same = component.replace("d", "f").replace("r", "m");
  const along = counts.find(([name, count]) => name === same && count > 2) ?? counts.sort((a, b) => b[1] - a[1])[0];
  return along ? along[0] : null;
}

export function againstLoad(readings, view, source) {
  const pick = () => {
    const component = view.get("component");
    const name = loadAxis(readings, view, component);
    const on = (i) => { const d = readings.direction(i); return d === "none" || d.slice(1) === name; };
    const inPose = (i) => view.get("pose") === null || readings.pose[i] === view.get("pose");
    const cyclesOn = new Set(readings.used(component).filter((i) => readings.direction(i).slice(1) === name).map((i) => readings.cycle[i]));
    return { component, name, used: readings.used(component).filter((i) => on(i) && inPose(i) && (cyclesOn.has(readings.cycle[i]) || readings.direction(i) !== "none")) };
  };
  const shape = (name) => (name.startsWith("m") ? "moment" : "force");
  return {
    id: "against-load", title: "Residual against load", n: readings.used(readings.components[0]).length, source, heavy: readings.count > many,
    follows: ["component", "model", "pose"], ...choosing(readings, view),
    say: "Loading ▲ and unloading ▽; a loop is friction, a step at zero a gap, a bend hardening. Grey: twice the noise. With a pose chosen only that pose.",
    numbers: () => {
      const { component, name, used } = pick();
      return { columns: ["reading", "branch", `${name} [N or N m]`, `residual of ${component} [m or rad]`],
        rows: used.map((i) => [readings.id[i], ["unstated", "loading", "unloading"][readings.branch[i]], readings.load[name][i], readings.residual(view.get("model"), component, i)]) };
    },
    draw(look) {
      const { component, name, used } = pick();
      const model = view.get("model");
      const r = scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const f = unitFor(shape(name), readings.largestLoad[name]);
      const noise = readings.noiseOf(component);
      const place = (i) => [readings.load[name][i] / f.factor, readings.residual(model, component, i) / r.factor];
      const lines = used.length > 1500 ? [] : [...groups(used, (i) => readings.cycle[i]).values()].filter((members) => members.length > 2 && members.length < 200).map((members) => ({
        type: "scatter", mode: "lines", meta: "guide", showlegend: false, hoverinfo: "skip", x: members.map((i) => place(i)[0]), y: members.map((i) => place(i)[1]), line: { color: look.line, width: 1 } }));
      return {
        data: [...lines, ...marks(readings, view, look, used, place, { branches: true })],
        layout: layout(look, { shapes: band(look, noise && (2 * noise) / r.factor), xaxis: axis(look, `${name} [${f.unit}]`), yaxis: axis(look, `residual of ${component} [${r.unit}]`, { range: sameRange(readings, component, r.factor) }) }),
      };
    },
  };
}

/** Mean of the odd and the even part of the residual over pairs of opposite loads, by level: rows [level, odd, error, even, error, pairs]. */
export function oddEven(readings, component, model, name) {
  const key = (i) => [readings.pose[i], Math.abs(readings.load[name][i]).toPrecision(6), readings.branch[i]].join("/");
  const on = readings.used(component).filter((i) => readings.direction(i).slice(1) === name);
  const byLevel = new Map();
  for (const members of groups(on, key).values()) {
    const part = (sign) => members.filter((i) => Math.sign(readings.load[name][i]) === sign).map((i) => readings.residual(model, component, i));
    const [up, down] = [part(1), part(-1)];
    if (!up.length || !down.length) continue;
    const level = Number(Math.abs(readings.load[name][members[0]]).toPrecision(6));
    if (!byLevel.has(level)) byLevel.set(level, []);
    byLevel.get(level).push([(mean(up) - mean(down)) / 2, (mean(up) + mean(down)) / 2]);
  }
  return [...byLevel].sort((a, b) => a[0] - b[0]).map(([level, parts]) => {
    const [odd, even] = [parts.map((p) => p[0]), parts.map((p) => p[1])];
    return [level, mean(odd), deviation(odd) / Math.sqrt(odd.length), mean(even), deviation(even) / Math.sqrt(even.length), parts.length];
  });
}

export function oddEvenPanel(readings, view, source) {
  const name = () => loadAxis(readings, { get: (key) => (key === "pose" ? null : view.get(key)) }, view.get("component"));
  return {
    id: "odd-even", title: "Odd and even part under reversal of load", n: oddEven(readings, readings.components[0], 0, name()).reduce((n, row) => n + row[5], 0), source, follows: ["component", "model"],
    say: "Mean over pairs of opposite loads. The odd part changes sign with the load (stiffness, gap, hardening), the even part does not (offset, drift). Grey: twice the noise of such a mean.",
    numbers: () => ({ columns: ["|load| [N or N m]", "odd [m or rad]", "standard error", "even", "standard error", "pairs"], rows: oddEven(readings, view.get("component"), view.get("model"), name()) }),
    draw(look) {
      const component = view.get("component");
      const rows = oddEven(readings, component, view.get("model"), name());
      const r = scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const f = unitFor(name().startsWith("m") ? "moment" : "force", readings.largestLoad[name()]);
      const one = (label, at, color) => ({ type: "scatter", mode: "lines+markers", name: label, x: rows.map((row) => row[0] / f.factor), y: rows.map((row) => row[at] / r.factor),
        error_y: { type: "data", array: rows.map((row) => (2 * row[at + 1]) / r.factor), color }, line: { color }, marker: { color, size: 7 } });
      const noise = readings.noiseOf(component);
      const pairs = rows.length ? mean(rows.map((row) => row[5])) : 1;
      return { data: [one("odd", 1, look.refitted), one("even", 3, look.held)],
        layout: layout(look, { shapes: band(look, noise && (2 * noise) / Math.sqrt(2 * pairs) / r.factor), xaxis: axis(look, `|${name()}| [${f.unit}]`, { rangemode: "tozero" }), yaxis: axis(look, `mean residual of ${component} [${r.unit}]`) }) };
    },
  };
}

export function fourPlot(readings, view, source) {
  const values = () => {
    const used = readings.used(view.get("component"));
    return { used, errors: used.map((i) => readings.whitened(view.get("model"), view.get("component"), i)) };
  };
  return {
    id: "four-plot", title: "Four-plot: is what is left noise?", n: readings.used(readings.components[0]).length, source, wide: true, height: 520, tall: 1200, heavy: readings.count > many,
    follows: ["component", "model", "pose"], ...choosing(readings, view),
    say: "Run order (drift), each against the one before (dependence), histogram and normal plot (outliers). Pure noise: level, round, bell-shaped, straight; grey marks that.",
    numbers: () => { const { used, errors } = values(); return { columns: ["reading", "order", readings.sigma ? "residual over noise" : "residual [m or rad]"], rows: used.map((i, k) => [readings.id[i], k + 1, errors[k]]) }; },
    draw(look, narrow) {
      const { used, errors } = values();
      const component = view.get("component");
      const scale = readings.sigma ? { factor: 1, unit: "noise" } : scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const e = errors.map((v) => v / scale.factor);
      const order = new Map(used.map((i, k) => [i, k]));
      const at = (x, y) => ({ trace: { xaxis: x, yaxis: y, showlegend: x === "x" } });
      const sorted = used.map((i, k) => [i, e[k]]).sort((a, b) => a[1] - b[1]);
      const rank = new Map(sorted.map(([i], k) => [i, normalQuantile((k + 0.625) / (e.length + 0.25))]));
      const most = largest(e);
      const centre = mean(e);
      const spread = readings.sigma ? 1 : deviation(e);
      const width = (2 * most) / Math.min(60, Math.max(12, Math.round(Math.sqrt(e.length) * 2)));
      const bell = Array.from({ length: 81 }, (_, k) => -most + (k * most) / 40);
      const density = (x) => (e.length * width * Math.exp(-0.5 * (x / spread) ** 2)) / (spread * Math.sqrt(2 * Math.PI));
      const name = scale.unit ? `residual [${scale.unit}]` : "residual";
      const guide = { meta: "guide", type: "scatter", mode: "lines", showlegend: false, hoverinfo: "skip", line: { color: look.noise, width: 2, dash: "dash" } };
      return {
        data: [
          ...marks(readings, view, look, used, (i) => [order.get(i) + 1, e[order.get(i)]], at("x", "y")),
          ...marks(readings, view, look, used.slice(1), (i) => [e[order.get(i) - 1], e[order.get(i)]], at("x2", "y2")),
          { type: "histogram", x: e, name: "all", xaxis: "x3", yaxis: "y3", showlegend: false, marker: { color: look.refitted, opacity: 0.8 }, xbins: { start: -most - width / 2, end: most + width, size: width } },
          { ...guide, x: bell, y: bell.map(density), xaxis: "x3", yaxis: "y3" },
          ...marks(readings, view, look, sorted.map(([i]) => i), (i) => [rank.get(i), e[order.get(i)]], at("x4", "y4")),
          { ...guide, x: [-3.5, 3.5], y: [centre * 0 - 3.5 * spread, 3.5 * spread], xaxis: "x4", yaxis: "y4" },
        ],
        layout: layout(look, {
          grid: { ...(narrow ? { rows: 4, columns: 1 } : { rows: 2, columns: 2 }), pattern: "independent", xgap: 0.12, ygap: 0.22 }, bargap: 0.05,
          shapes: readings.sigma ? [["x domain", "y"], ["x2 domain", "y2"]].map(([xref, yref]) => ({ type: "rect", layer: "below", xref, yref, x0: 0, x1: 1, y0: -2, y1: 2, fillcolor: look.noise, opacity: 0.22, line: { width: 0 } })) : [],
          xaxis: axis(look, "run order"), yaxis: axis(look, name), xaxis2: axis(look, "the one before"), yaxis2: axis(look, name),
          xaxis3: axis(look, name), yaxis3: axis(look, "count"), xaxis4: axis(look, "normal quantile"), yaxis4: axis(look, name),
        }),
      };
    },
  };
}
