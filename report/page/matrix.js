// 6x6 matrices: a heat map that makes blocks of different units comparable, with the numbers in it; ellipsoids.
import { axis, diverging, layout, onColours } from "./look.js";
import { number, unitFor } from "./units.js";

const order = ["tx", "ty", "tz", "rx", "ry", "rz"];
const loads = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];
const blockKinds = {
  compliance: ["compliance", "crossing", "turning"],
  stiffness: ["stiffness", "force", "torsion"],
};
const blockUnits = (what, matrix) => {
  const most = (rows, cols) =>
    Math.max(...rows.flatMap((i) => cols.map((j) => Math.abs(matrix[i][j]))));
  const [low, high] = [
    [0, 1, 2],
    [3, 4, 5],
  ];
  const [a, b, c] = blockKinds[what];
  return [
    [unitFor(a, most(low, low)), unitFor(b, most(low, high))],
    [unitFor(b, most(low, high)), unitFor(c, most(high, high))],
  ];
};
const half = (i) => (i < 3 ? 0 : 1);

export function matrixFigure(what, { matrix, bars, title, id, say = "" }, source) {
  const scaled = matrix.map((row, i) =>
    row.map((v, j) => v / Math.sqrt(Math.abs(matrix[i][i] * matrix[j][j])) || 0),
  );
  const units = blockUnits(what, matrix);
  const shown = (i, j) => {
    const { factor } = units[half(i)][half(j)];
    if (Math.abs(scaled[i][j]) < 1e-6) return "0";
    return number(matrix[i][j] / factor) + (bars ? `<br>± ${number(bars[i][j] / factor, 2)}` : "");
  };
  const names = what === "compliance" ? [order, loads] : [loads, order];
  const unitText = `upper left in ${units[0][0].unit}, off-diagonal blocks in ${units[0][1].unit}, lower right in ${units[1][1].unit}`;
  return {
    id,
    title,
    n: 36,
    source,
    height: 420,
    paper: 350,
    least: 300,
    say: `${say}Numbers: ${unitText}. Colours: each entry over the root of its diagonal entries, from -1 to 1.`,
    numbers: () => ({
      columns: ["row", "column", "value [SI]", ...(bars ? ["error bar"] : [])],
      rows: matrix.flatMap((row, i) =>
        row.map((v, j) => [names[0][i], names[1][j], v, ...(bars ? [bars[i][j]] : [])]),
      ),
    }),
    draw: (look, narrow) => ({
      data: [
        {
          type: "heatmap",
          z: scaled,
          x: names[1],
          y: names[0],
          zmin: -1,
          zmax: 1,
          colorscale: diverging(look),
          xgap: 2,
          ygap: 2,
          text: matrix.map((row, i) => row.map((_, j) => shown(i, j))),
          texttemplate: "%{text}",
          textfont: { ...onColours(look), ...(narrow ? { size: 9 } : {}) },
          hovertemplate: "%{y}, %{x}: %{text}<extra></extra>",
          showscale: !narrow,
          colorbar: { thickness: 10, tickvals: [-1, 0, 1] },
        },
      ],
      layout: layout(look, {
        showlegend: false,
        margin: { l: narrow ? 26 : 40, r: narrow ? 2 : 10, t: 30, b: 30 },
        xaxis: axis(look, "", { side: "top", type: "category" }),
        yaxis: axis(look, "", { autorange: "reversed", type: "category" }),
      }),
    }),
  };
}

/** Where the point goes under all forces of one size: the image of the sphere under the 3x3 compliance of forces. */
export function ellipsoid(compliance, centre, scale, factor, color) {
  const steps = 24;
  const [x, y, z] = [[], [], []];
  for (let a = 0; a <= steps; ++a) {
    const rows = [[], [], []];
    for (let b = 0; b <= steps; ++b) {
      const [u, v] = [(Math.PI * a) / steps, (2 * Math.PI * b) / steps];
      const f = [Math.sin(u) * Math.cos(v), Math.sin(u) * Math.sin(v), Math.cos(u)];
      for (let k = 0; k < 3; ++k)
        rows[k].push(
          (centre[k] +
            scale * (compliance[k][0] * f[0] + compliance[k][1] * f[1] + compliance[k][2] * f[2])) /
            factor,
        );
    }
    x.push(rows[0]);
    y.push(rows[1]);
    z.push(rows[2]);
  }
  return {
    type: "surface",
    x,
    y,
    z,
    surfacecolor: x.map((row) => row.map(() => 0)),
    colorscale: [
      [0, color],
      [1, color],
    ],
    showscale: false,
    opacity: 0.45,
    hoverinfo: "skip",
    meta: "guide",
    name: "compliance ellipsoid",
  };
}
