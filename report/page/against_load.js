// Residual against load, with both branches; and load at one joint against its deflection.
import { plain } from "./dom.js";
import { axis, layout } from "./look.js";
import { band, marks, ofReadings, sameRange, scaleOf } from "./marks.js";
import { groups, largest } from "./numbers.js";
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

/** The readings of a curve, with the deviation of their deflection along one axis. */
function readingMarks(curve, look, place, errorBar, factor) {
  return {
    type: "scatter",
    mode: "markers",
    name: "readings",
    ...place,
    [errorBar]: {
      type: "data",
      array: curve.deviation.map((d) => d / factor),
      thickness: 0.7,
      width: 0,
      color: look.quiet,
    },
    marker: { color: look.ink, size: 5 },
    text: curve.id.map((id) => plain(`reading ${id}`)),
    hovertemplate: "%{text}: %{x:.4g}, %{y:.4g}<extra></extra>",
  };
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

/** Load on a joint against its deflection: readings, and the fitted model without and with the effect. */
export function jointCurve(curve, source) {
  const [angle, moment] = curve.turns ? ["angle", "moment"] : ["length", "force"];
  const x = unitFor(angle, largest([...curve.measured, ...curve.with]));
  const y = unitFor(moment, largest(curve.load));
  const all = curve.load.map((_, i) => i);
  const byLoad = [...all].sort((a, b) => curve.load[a] - curve.load[b]);
  const path = (column, members) => ({
    x: members.map((i) => curve[column][i] / x.factor),
    y: members.map((i) => curve.load[i] / y.factor),
  });
  return {
    id: "joint-curve",
    title: `Load at ${curve.place} against its deflection`,
    n: all.length,
    source,
    height: 420,
    say: `Dots: readings, what the model with ${curve.effect} leaves taken to be of this joint alone; whiskers: the noise. Line: that model. Dashed: the fitted model without the effect.`,
    numbers: () => ({
      columns: ["reading", "load [N or N m]", "measured [m or rad]", "without", "with", "sd"],
      rows: all.map((i) => [
        curve.id[i],
        curve.load[i],
        curve.measured[i],
        curve.without[i],
        curve.with[i],
        curve.deviation[i],
      ]),
    }),
    draw(look) {
      const cycles = [...groups(all, (i) => curve.cycle[i]).values()];
      const loops = cycles.filter((members) => members.length > 2);
      const lines = (loops.length ? loops : [byLoad]).map((members, k) => ({
        type: "scatter",
        mode: "lines",
        meta: "guide",
        name: `with ${plain(curve.effect)}`,
        legendgroup: "with",
        showlegend: k === 0,
        hoverinfo: "skip",
        ...path("with", members),
        line: { color: look.final, width: 2 },
      }));
      return {
        data: [
          {
            type: "scatter",
            mode: "lines",
            meta: "guide",
            name: "fitted, without it",
            hoverinfo: "skip",
            ...path("without", byLoad),
            line: { color: look.bad, width: 2, dash: "dash" },
          },
          ...lines,
          readingMarks(curve, look, path("measured", all), "error_x", x.factor),
        ],
        layout: layout(look, {
          xaxis: axis(look, `deflection of ${curve.place} [${x.unit}]`),
          yaxis: axis(look, `load on it [${y.unit}]`),
        }),
      };
    },
  };
}

/** The part of that deflection that the spring does not explain, against the load: where a loop, a step or a bend is seen. */
export function extraDeflection(curve, source) {
  const all = curve.load.map((_, i) => i);
  const extra = (column, i) => curve[column][i] - curve.spring[i];
  const x = unitFor(curve.turns ? "moment" : "force", largest(curve.load));
  const y = unitFor(
    curve.turns ? "angle" : "length",
    largest(all.flatMap((i) => [extra("measured", i), extra("with", i)])),
  );
  return {
    id: "extra-deflection",
    title: `What the spring of ${curve.place} does not explain`,
    n: all.length,
    source,
    height: 420,
    say: `Deflection less that of its spring, against the load. A loop is friction, a step at no load a gap, a bend stiffening. Line: ${curve.effect}.`,
    numbers: () => ({
      columns: ["reading", "load [N or N m]", "measured less the spring [m or rad]", "with"],
      rows: all.map((i) => [curve.id[i], curve.load[i], extra("measured", i), extra("with", i)]),
    }),
    draw(look) {
      const cycles = [...groups(all, (i) => curve.cycle[i]).values()];
      const loops = cycles.filter((members) => members.length > 2);
      const byLoad = [...all].sort((a, b) => curve.load[a] - curve.load[b]);
      const place = (column, members) => ({
        x: members.map((i) => curve.load[i] / x.factor),
        y: members.map((i) => extra(column, i) / y.factor),
      });
      return {
        data: [
          ...(loops.length ? loops : [byLoad]).map((members, k) => ({
            type: "scatter",
            mode: "lines",
            meta: "guide",
            name: plain(curve.effect),
            legendgroup: "with",
            showlegend: k === 0,
            hoverinfo: "skip",
            ...place("with", members),
            line: { color: look.final, width: 2 },
          })),
          readingMarks(curve, look, place("measured", all), "error_y", y.factor),
        ],
        layout: layout(look, {
          xaxis: axis(look, `load at ${curve.place} [${x.unit}]`),
          yaxis: axis(look, `extra deflection [${y.unit}]`),
        }),
      };
    },
  };
}
