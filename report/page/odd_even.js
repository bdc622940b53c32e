// Parts of the residual that change sign with the load, and that do not.
import { loadAxis } from "./against_load.js";
import { axis, layout } from "./look.js";
import { band, scaleOf } from "./marks.js";
import { deviation, groups, mean } from "./numbers.js";
import { unitFor } from "./units.js";

/** Mean of the odd and the even part of the residual over pairs of opposite loads, by level: rows [level, odd, error, even, error, pairs]. */
export function oddEven(readings, component, model, name) {
  const key = (i) =>
    [readings.pose[i], Math.abs(readings.load[name][i]).toPrecision(6), readings.branch[i]].join(
      "/",
    );
  const on = readings.used(component).filter((i) => readings.direction(i).slice(1) === name);
  const byLevel = new Map();
  for (const members of groups(on, key).values()) {
    const part = (sign) =>
      members
        .filter((i) => Math.sign(readings.load[name][i]) === sign)
        .map((i) => readings.residual(model, component, i));
    const [up, down] = [part(1), part(-1)];
    if (!up.length || !down.length) continue;
    const level = Number(Math.abs(readings.load[name][members[0]]).toPrecision(6));
    if (!byLevel.has(level)) byLevel.set(level, []);
    byLevel.get(level).push([(mean(up) - mean(down)) / 2, (mean(up) + mean(down)) / 2]);
  }
  return [...byLevel]
    .sort((a, b) => a[0] - b[0])
    .map(([level, parts]) => {
      const [odd, even] = [parts.map((p) => p[0]), parts.map((p) => p[1])];
      return [
        level,
        mean(odd),
        deviation(odd) / Math.sqrt(odd.length),
        mean(even),
        deviation(even) / Math.sqrt(even.length),
        parts.length,
      ];
    });
}

export function oddEvenPanel(readings, view, source) {
  const name = () =>
    loadAxis(
      readings,
      { get: (key) => (key === "pose" ? null : view.get(key)) },
      view.get("component"),
    );
  return {
    id: "odd-even",
    title: "Odd and even part under reversal of load",
    n: oddEven(readings, readings.components[0], 0, name()).reduce((n, row) => n + row[5], 0),
    source,
    follows: ["component", "model"],
    say: "Mean over pairs of opposite loads. The odd part changes sign with the load (stiffness, gap, hardening), the even part does not (offset, drift). Grey: twice the noise of such a mean.",
    numbers: () => ({
      columns: [
        "|load| [N or N m]",
        "odd [m or rad]",
        "standard error",
        "even",
        "standard error",
        "pairs",
      ],
      rows: oddEven(readings, view.get("component"), view.get("model"), name()),
    }),
    draw(look) {
      const component = view.get("component");
      const rows = oddEven(readings, component, view.get("model"), name());
      const r = scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const f = unitFor(name().startsWith("m") ? "moment" : "force", readings.largestLoad[name()]);
      const one = (label, at, color) => ({
        type: "scatter",
        mode: "lines+markers",
        name: label,
        x: rows.map((row) => row[0] / f.factor),
        y: rows.map((row) => row[at] / r.factor),
        error_y: { type: "data", array: rows.map((row) => (2 * row[at + 1]) / r.factor), color },
        line: { color },
        marker: { color, size: 7 },
      });
      const noise = readings.noiseOf(component);
      const pairs = rows.length ? mean(rows.map((row) => row[5])) : 1;
      return {
        data: [one("odd", 1, look.fitted), one("even", 3, look.held)],
        layout: layout(look, {
          shapes: band(look, noise && (2 * noise) / Math.sqrt(2 * pairs) / r.factor),
          xaxis: axis(look, `|${name()}| [${f.unit}]`, { rangemode: "tozero" }),
          yaxis: axis(look, `mean residual of ${component} [${r.unit}]`),
        }),
      };
    },
  };
}
