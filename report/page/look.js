// Colours and common layout of charts, from the style sheet, so that both follow light and dark.

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
      "designed",
      "refitted",
      "mended",
      "held",
      "noise",
      "chosen",
      "bad",
      "good",
    ].map((name) => [name, colour(name)]),
  );
}

/** Of a model, by its place among the models: before, refitted, mended. */
export const modelColour = (look, index) =>
  [look.designed, look.refitted, look.mended][Math.min(index, 2)];

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
  });
  return {
    xaxis: one("x"),
    yaxis: one("y"),
    zaxis: one("z"),
    aspectmode: "data",
    bgcolor: look.paper,
    camera: { eye: { x: 1.25, y: -1.25, z: 0.75 }, up: { x: 0, y: 0, z: 1 } },
    ...more,
  };
}

/** From good over doubtful to bad; from the paper's colour on, so that the eye finds what is large. */
export const rising = (look) => [
  [0, look.panel],
  [0.5, "#e0a458"],
  [1, "#b3261e"],
];
/** About zero. */
export const diverging = (look) => [
  [0, "#2c6fbb"],
  [0.5, look.panel],
  [1, "#c0561f"],
];
