// One point a reading: how points look, and how they link the charts.
import { plain } from "./dom.js";
import { largest } from "./numbers.js";
import { kindOf, unitFor } from "./units.js";

export const many = 3000; // more points than that are drawn by WebGL

export const scatterType = (count) => (count > many ? "scattergl" : "scatter");

/** Traces of points: fitted, kept out, and those of the chosen pose on top. `place(i)`: [x, y]. */
export function marks(readings, view, look, indices, place, more = {}) {
  const chosen = view.get("pose");
  const symbols = (i) =>
    readings.branch[i] === 2
      ? "triangle-down-open"
      : readings.branch[i] === 1
        ? "triangle-up"
        : "circle";
  const trace = (name, members, color, size, symbol) => ({
    type: scatterType(indices.length),
    mode: "markers",
    name,
    x: members.map((i) => place(i)[0]),
    y: members.map((i) => place(i)[1]),
    customdata: members,
    text: members.map((i) => plain(readings.text(i))),
    hovertemplate: "%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>",
    marker: {
      color,
      size,
      opacity: members.length > many ? 0.5 : 0.85,
      symbol: symbol ?? (more.branches ? members.map(symbols) : "circle"),
    },
    ...more.trace,
  });
  const fitted = indices.filter((i) => !readings.heldOut(i));
  const held = indices.filter((i) => readings.heldOut(i));
  const traces = [trace("fitted", fitted, look.fitted, 5)];
  if (held.length) traces.push(trace("kept out", held, look.held, 6));
  const selected = indices.filter((i) => readings.pose[i] === chosen);
  traces.push({
    ...trace("chosen pose", selected, look.chosen, 9, "circle-open"),
    meta: "guide",
    visible: chosen !== null,
  });
  return traces;
}

export const choosing = (readings, view) => ({
  choose: (point) => {
    if (point.customdata !== undefined) view.set({ pose: readings.pose[point.customdata] });
  },
  step: (by) => {
    const count = readings.poses.length;
    const pose = view.get("pose");
    view.set({ pose: pose === null ? 0 : (pose + by + count) % count });
  },
});

/** A chart with a point for each reading: the common parts, and the words of this one. */
export const ofReadings = (readings, view, source, spec) => ({
  n: () => readings.used(view.get("component")).length,
  source,
  heavy: readings.count > many,
  follows: ["component", "model", "pose"],
  ...choosing(readings, view),
  ...spec,
});

export const scaleOf = (readings, component, value) =>
  unitFor(
    kindOf(component),
    largest(readings.models.flatMap((_, m) => readings.used(component).map((i) => value(m, i)))),
  );

// A range over all models, so that axes stay when the model changes.
export function sameRange(readings, component, factor) {
  const most =
    (1.05 *
      largest(
        readings.models.flatMap((_, m) =>
          readings.used(component).map((i) => readings.residual(m, component, i)),
        ),
      )) /
    factor;
  return [-most, most];
}

export const band = (look, half, orientation = "y") =>
  half
    ? [
        {
          type: "rect",
          layer: "below",
          [orientation === "y" ? "xref" : "yref"]: "paper",
          ...(orientation === "y"
            ? { x0: 0, x1: 1, y0: -half, y1: half }
            : { y0: 0, y1: 1, x0: -half, x1: half }),
          fillcolor: look.noise,
          opacity: 0.22,
          line: { width: 0 },
        },
      ]
    : [];
