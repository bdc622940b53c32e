// Residual against load, with both branches.
import { axis, layout } from "./look.js";
import { band, marks, ofReadings, sameRange, scaleOf } from "./marks.js";
import { groups } from "./numbers.js";
import { unitFor } from "./units.js";

/** The axis of load that most readings have, and readings along it. */
export function loadAxis(readings, view, component) {
  const used = readings
    .used(component)
    .filter((i) => view.get("pose") === null || readings.pose[i] === view.get("pose"));
  const counts = readings.loads.map((name) => [
    name,
    used.filter((i) => ["+", "-"].some((s) => readings.direction(i) === s + name)).length,
  ]);
  const same = component.replace("d", "f").replace("r", "m");
  const along =
    counts.find(([name, count]) => name === same && count > 2) ??
    counts.sort((a, b) => b[1] - a[1])[0];
  return along ? along[0] : null;
}

export function againstLoad(readings, view, source) {
  const pick = () => {
    const component = view.get("component");
    const name = loadAxis(readings, view, component);
    const on = (i) => {
      const d = readings.direction(i);
      return d === "none" || d.slice(1) === name;
    };
    const inPose = (i) => view.get("pose") === null || readings.pose[i] === view.get("pose");
    const cyclesOn = new Set(
      readings
        .used(component)
        .filter((i) => readings.direction(i).slice(1) === name)
        .map((i) => readings.cycle[i]),
    );
    return {
      component,
      name,
      used: readings
        .used(component)
        .filter(
          (i) =>
            on(i) &&
            inPose(i) &&
            (cyclesOn.has(readings.cycle[i]) || readings.direction(i) !== "none"),
        ),
    };
  };
  const shape = (name) => (name.startsWith("m") ? "moment" : "force");
  return ofReadings(readings, view, source, {
    id: "against-load",
    title: "Residual against load",
    n: () => pick().used.length,
    say: "Loading ▲ and unloading ▽; a loop is friction, a step at 0 a gap, a bend hardening. Grey: twice the noise. With a pose chosen only that pose.",
    numbers: () => {
      const { component, name, used } = pick();
      return {
        columns: ["reading", "branch", `${name} [N or N m]`, `residual of ${component} [m or rad]`],
        rows: used.map((i) => [
          readings.id[i],
          ["unstated", "loading", "unloading"][readings.branch[i]],
          readings.load[name][i],
          readings.residual(view.get("model"), component, i),
        ]),
      };
    },
    draw(look) {
      const { component, name, used } = pick();
      const model = view.get("model");
      const r = scaleOf(readings, component, (m, i) => readings.residual(m, component, i));
      const f = unitFor(shape(name), readings.largestLoad[name]);
      const noise = readings.noiseOf(component);
      const place = (i) => [
        readings.load[name][i] / f.factor,
        readings.residual(model, component, i) / r.factor,
      ];
      const lines =
        used.length > 1500
          ? []
          : [...groups(used, (i) => readings.cycle[i]).values()]
              .filter((members) => members.length > 2 && members.length < 200)
              .map((members) => ({
                type: "scatter",
                mode: "lines",
                meta: "guide",
                showlegend: false,
                hoverinfo: "skip",
                x: members.map((i) => place(i)[0]),
                y: members.map((i) => place(i)[1]),
                line: { color: look.line, width: 1 },
              }));
      return {
        data: [...lines, ...marks(readings, view, look, used, place, { branches: true })],
        layout: layout(look, {
          shapes: band(look, noise && (2 * noise) / r.factor),
          xaxis: axis(look, `${name} [${f.unit}]`),
          yaxis: axis(look, `residual of ${component} [${r.unit}]`, {
            range: sameRange(readings, component, r.factor),
          }),
        }),
      };
    },
  });
}
