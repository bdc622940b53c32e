// Colours and common layout of charts, from the style sheet, so that both follow light and dark.
import { range } from "./numbers.js";

export function look() {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  return Object.fromEntries(
    [
      "ink",
      "quiet",
      "line",
      "paper",
      "panel",
      "nominal",
      "fitted",
      "final",
      "held",
      "noise",
      "chosen",
      "bad",
      "good",
      "cold",
      "hot",
      "warm",
      "hottest",
    ].map((name) => [name, colour(name)]),
  );
}

/** Colour of a model, by its place among the models: nominal, fitted, final. */
export const modelColour = (look, index) =>
  [look.nominal, look.fitted, look.final][Math.min(index, 2)];

export function axis(look, title, more = {}) {
  return {
    title: { text: title, standoff: 8 },
    color: look.ink,
    gridcolor: look.line,
    zerolinecolor: look.line,
    linecolor: look.line,
    automargin: true,
    ...more,
  };
}

export function layout(look, more = {}) {
  return {
    paper_bgcolor: look.paper,
    plot_bgcolor: look.paper,
    font: { color: look.ink, family: "system-ui, sans-serif", size: 13 },
    margin: { l: 60, r: 16, t: 52, b: 44 },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { size: 12 } },
    hoverlabel: { bgcolor: look.panel, bordercolor: look.line, font: { color: look.ink } },
    showlegend: true,
    hovermode: "closest",
    uirevision: "kept",
    ...more,
  };
}

export function scene(look, unit, more = {}) {
  const one = (name) => ({
    title: { text: `${name} [${unit}]` },
    color: look.ink,
    gridcolor: look.line,
    zerolinecolor: look.line,
    backgroundcolor: look.paper,
    showbackground: false,
    nticks: 5,
  });
  return {
    xaxis: one("x"),
    yaxis: one("y"),
    zaxis: one("z"),
    bgcolor: look.paper,
    camera: { eye: { x: 1.25, y: -1.25, z: 0.75 }, up: { x: 0, y: 0, z: 1 }, center: { x: 0, y: 0, z: -0.12 } },
    ...more,
  };
}

/** Room around what is drawn: the same scale along all axes, and all of it in sight however slender it is. */
export function framed(room, data) {
  const solid = data.filter((t) => /3d$/.test(t.type) && t.visible !== "legendonly" && t.x.length);
  const ranges = ["x", "y", "z"].map((name) => range(solid.flatMap((t) => range(t[name]))));
  const longest = Math.max(...ranges.map(([low, high]) => high - low));
  if (!(longest > 0)) return { ...room, aspectmode: "data" };
  const half = ranges.map(([low, high]) => 0.52 * Math.max(high - low, 0.15 * longest));
  const axes = ["xaxis", "yaxis", "zaxis"].map((name, k) => {
    const middle = (ranges[k][0] + ranges[k][1]) / 2;
    const nticks = Math.max(2, Math.round((5 * half[k]) / (0.52 * longest)));  // as close as along the longest
    return [name, { ...room[name], nticks, range: [middle - half[k], middle + half[k]] }];
  });
  // What is flat or slender may come nearer than a cube, which fills the view.
  const scale = Math.min(1.4, 1.5 / Math.hypot(...half.map((h) => h / (0.52 * longest))));
  const [x, y, z] = half.map((h) => (scale * h) / (0.52 * longest));
  return { ...room, ...Object.fromEntries(axes), aspectmode: "manual", aspectratio: { x, y, z } };
}

/** From good over doubtful to bad; from the paper's colour on, so that the eye finds what is large. Ink is legible on all of it. */
export const rising = (look) => [
  [0, look.panel],
  [0.5, look.warm],
  [1, look.hottest],
];
/** About zero. */
export const diverging = (look) => [
  [0, look.cold],
  [0.5, look.panel],
  [1, look.hot],
];
/** Of numbers on such colours. */
export const onColours = (look) => ({ size: 11, color: look.ink });
