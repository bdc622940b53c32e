// Horizontal bars with a name each, and limits to read them by.
import { axis, layout } from "./look.js";

/**
 * One bar a row, first on top. rows: names (HTML of Plotly), values, colours, hover (text of each); text on the bars, if any;
 * limits: [value, colour, width] dashed lines; x: the axis; small: names in small print.
 */
export function bars(look, rows) {
  const { names, values, colours, text, hover, limits = [], small, more } = rows;
  const { title, ...range } = rows.x;
  return {
    data: [
      {
        type: "bar",
        orientation: "h",
        y: names.map((_, k) => k),
        x: values,
        marker: { color: colours },
        ...(text ? { text, textposition: "auto" } : { textposition: "none" }),
        insidetextfont: { size: 11, color: look.paper },
        outsidetextfont: { size: 11, color: look.ink },
        cliponaxis: false,
        hovertemplate: hover.map((line) => `${line}<extra></extra>`),
      },
    ],
    layout: layout(look, {
      showlegend: false,
      margin: { l: 60, r: 16, t: 30, b: 44 },
      shapes: limits.map(([at, color, width]) => ({
        type: "line",
        yref: "paper",
        x0: at,
        x1: at,
        y0: 0,
        y1: 1,
        line: { color, width, dash: "dash" },
      })),
      xaxis: axis(look, title, range),
      yaxis: axis(look, "", {
        autorange: "reversed",
        tickvals: names.map((_, k) => k),
        ticktext: names,
        showgrid: false,
        ...(small ? { tickfont: { size: 11 } } : {}),
      }),
      bargap: 0.12,
      ...more,
    }),
  };
}
