// Sections of identify and beam.
import { choice, element, list, plain, slider } from "./dom.js";
import { Figure } from "./figure.js";
import { axis, diverging, layout, scene } from "./look.js";
import { matrixFigure } from "./matrix.js";
import { number, quantity, unitFor } from "./units.js";
import { View } from "./view.js";
import { roundFactor } from "./workspace.js";

const motions = ["tx", "ty", "tz", "rx", "ry", "rz"];
const isLinkMatrix = (m) => Array.isArray(m) && m.length === 6;
export const isLink = ({ result }) => isLinkMatrix(result.compliance) && result.link !== undefined;
export const isBeam = ({ result }) => Array.isArray(result.models) && result.sections !== undefined;

function surfaceFigure(surface, view, source) {
  const count = surface.points.length / 3;
  const p = (i, k) => surface.points[3 * i + k] * surface.point_unit;
  const range = [0, 1, 2].map((k) => { let [low, high] = [Infinity, -Infinity]; for (let i = 0; i < count; ++i) { low = Math.min(low, p(i, k)); high = Math.max(high, p(i, k)); } return high - low; });
  const size = Math.max(...range);
  const shape = () => surface.shapes[view.get("shape")];
  const largest = () => { let most = 0; const s = shape().displacements; for (let i = 0; i < s.length; i += 3) most = Math.max(most, Math.hypot(s[i], s[i + 1], s[i + 2])); return most * shape().unit; };
  const standard = () => roundFactor((0.12 * size) / largest());
  const colours = (look) => ["#9fb0c2", look.bad, look.held, "#8a4fbf", "#12805c", "#b0136f"];
  const names = ["free surface", ...surface.interfaces.map((x, k) => `${k === 0 ? "fixed" : "loaded"}: ${x.name}`)];
  const size_of = (i) => { const s = shape(); return Math.hypot(s.displacements[3 * i], s.displacements[3 * i + 1], s.displacements[3 * i + 2]) * s.unit; };
  return {
    id: "surface", title: "The link and how it deforms", n: count, source, height: 560, wide: true, heavy: true, follows: ["shape", "scale", "paint"],
    say: "Fixed interface red, loaded one orange. Deformed by one unit load at the reference point of the loaded interface, as many times larger as the slider says.",
    controls: [choice("Unit load", surface.shapes.map((s, k) => [k, `${s.load} = 1 ${/M/.test(s.load) ? "N m" : "N"}`]), 0, (v) => view.set({ shape: Number(v) })), " ",
      slider("Deformation", { from: 0, to: 3, step: 0.05, value: 1, show: (v) => `${number(v)} x standard` }, (v) => view.set({ scale: v })), " ",
      choice("Colour", [["interface", "interfaces"], ["size", "displacement"]], "interface", (v) => view.set({ paint: v }))],
    numbers: () => ({ columns: ["x [m]", "y [m]", "z [m]", "ux [m]", "uy [m]", "uz [m]"], rows: Array.from({ length: count }, (_, i) => [0, 1, 2].map((k) => p(i, k)).concat([0, 1, 2].map((k) => shape().displacements[3 * i + k] * shape().unit))) }),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const magnify = standard() * view.get("scale");
      const s = shape();
      const at = (k) => Array.from({ length: count }, (_, i) => (p(i, k) + magnify * s.displacements[3 * i + k] * s.unit) / factor);
      const corners = (k, members) => members.map((t) => surface.triangles[3 * t + k]);
      const palette = colours(look);
      const mesh = (members, extra) => ({ type: "mesh3d", x: at(0), y: at(1), z: at(2), i: corners(0, members), j: corners(1, members), k: corners(2, members), flatshading: true, hoverinfo: "skip", lighting: { ambient: 0.7, diffuse: 0.6, specular: 0.1, facenormalsepsilon: 0, vertexnormalsepsilon: 0 }, ...extra });
      const every = surface.of_interface.map((_, t) => t);
      const u = unitFor("length", largest());
      const data = view.get("paint") === "size"
        ? [mesh(every, { intensity: Array.from({ length: count }, (_, i) => size_of(i) / u.factor), colorscale: "Viridis", colorbar: { title: { text: `displacement [${u.unit}]`, side: "right" }, thickness: 12 } })]
        : names.map((name, tag) => mesh(every.filter((t) => surface.of_interface[t] === tag), { color: palette[tag % palette.length], name: plain(name), showlegend: true }));
      return { data, layout: layout(look, { margin: { l: 0, r: 0, t: 30, b: 0 }, scene: scene(look, unit), annotations: [{ text: `shown ${number(magnify)} times; largest displacement ${quantity(largest(), "length")}`, showarrow: false, xref: "paper", yref: "paper", x: 0, y: 0, xanchor: "left", yanchor: "bottom" }] }) };
    },
  };
}

function bracketFigure(result, source) {
  const { rigid, distributing } = result.bracket;
  const entries = motions.map((name, k) => [name, rigid[k][k], distributing[k][k], result.compliance[k][k]]);
  const low = (e) => 100 * (e[1] / e[3] - 1);
  const high = (e) => 100 * (e[2] / e[3] - 1);
  return {
    id: "bracket", title: "What the fastening decides", n: 6, source, say: "Compliance with all interfaces rigid (lower bound) and distributing (upper bound), beside the coupling of the link file: the honest uncertainty of how the link is fastened.",
    numbers: () => ({ columns: ["entry", "rigid [SI]", "distributing [SI]", "as in the link file"], rows: entries }),
    draw: (look) => ({
      data: [...entries.map((e) => ({ type: "scatter", mode: "lines", meta: "guide", showlegend: false, hoverinfo: "skip", x: [low(e), high(e)], y: [e[0], e[0]], line: { color: look.noise, width: 6 } })),
        ...[["rigid", low, look.refitted], ["distributing", high, look.held]].map(([name, f, color]) => ({ type: "scatter", mode: "markers", name, x: entries.map(f), y: motions, marker: { size: 11, color }, hovertemplate: "%{y}: %{x:.3g} %<extra></extra>" }))],
      layout: layout(look, { xaxis: axis(look, "compliance beside the link file's coupling [%]"), yaxis: axis(look, "", { type: "category", autorange: "reversed" }) }),
    }),
  };
}

function convergenceFigure(result, source) {
  const meshes = result.error.meshes;
  return {
    id: "convergence", title: "Convergence", n: meshes.length, source, say: `Estimated error of the worst significant entry on each mesh${result.error.asked ? `; asked for: ${number(100 * result.error.asked, 2)} %` : ""}. ${result.error.shortfall || ""}`,
    numbers: () => ({ columns: ["unknowns", "elements", "estimated relative error"], rows: meshes.map((m) => [m.unknowns, m.elements, m.relative_error]) }),
    draw: (look) => ({
      data: [{ type: "scatter", mode: "lines+markers", name: "estimated error", x: meshes.map((m) => m.unknowns), y: meshes.map((m) => 100 * m.relative_error), line: { color: look.refitted }, marker: { size: 9 } }],
      layout: layout(look, { showlegend: false, xaxis: axis(look, "unknowns", { type: "log" }), yaxis: axis(look, "estimated error [%]", { type: "log" }),
        shapes: result.error.asked ? [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: 100 * result.error.asked, y1: 100 * result.error.asked, line: { color: look.good, dash: "dash" } }] : [] }),
    }),
  };
}

export function linkSection({ result, picture }) {
  const source = `Source: ${result.inputs?.mesh_file ?? result.link}, ${result.mesh ? `${result.mesh.elements} tetrahedra` : "no mesh"}.`;
  const said = [result.mass ? `Mass ${number(result.mass)} kg.` : null, result.error?.relative !== undefined ? `Every significant entry is known to ${number(100 * result.error.relative, 2)} %.` : null,
    result.eigen_stiffness ? `Eigen-stiffnesses ${result.eigen_stiffness.translation.map((v) => quantity(v, "stiffness")).join(", ")}; ${result.eigen_stiffness.rotation.map((v) => quantity(v, "torsion")).join(", ")}.` : null,
    ...(result.warnings ?? []).map((text) => `Warning: ${text}`)].filter(Boolean);
  const charts = element("div", { class: "charts" });
  const node = element("section", {}, element("h2", {}, `Link: ${result.link}`), list(said), charts);
  const view = new View({ shape: 0, scale: 1, paint: "interface" });
  const add = (spec) => charts.append(new Figure(spec, view).node);
  if (picture?.surface?.shapes?.length) add(surfaceFigure(picture.surface, view, source));
  add(matrixFigure("compliance", { matrix: result.compliance, bars: isLinkMatrix(result.error?.bar) ? result.error.bar : undefined, id: "link-compliance", title: "6x6 compliance with error bars" }, source));
  if (isLinkMatrix(result.bracket?.rigid)) add(bracketFigure(result, source));
  if (result.error?.meshes?.length > 1) add(convergenceFigure(result, source));
  return node;
}

export function beamSection({ result }) {
  const source = `Source: ${result.link}.`;
  const charts = element("div", { class: "charts" });
  const node = element("section", {}, element("h2", {}, `Beam or finite elements: ${result.link}`), result.verdict ? element("p", { class: "verdict" }, result.verdict) : null, charts);
  const add = (spec) => charts.append(new Figure(spec, new View({})).node);
  for (const [k, c] of (result.comparison ?? []).entries()) {
    const most = 100 * Math.max(...result.comparison.map((x) => x.worst_error));
    const shown = c.errors.map((row) => row.map((v) => (v === null ? null : 100 * v)));
    add({ id: `beam-errors-${k}`, title: `${c.model} against finite elements`, n: 36, source, height: 380, least: 480, say: `Error of each significant entry of the compliance [%]; the worst is ${number(100 * c.worst_error, 2)} %. Blank: not significant.`,
      numbers: () => ({ columns: ["row", ...motions], rows: c.errors.map((row, i) => [motions[i], ...row]) }),
      draw: (look) => ({ data: [{ type: "heatmap", z: shown, x: motions, y: motions, zmin: -most, zmax: most, colorscale: diverging(look), xgap: 2, ygap: 2, text: shown.map((row) => row.map((v) => (v === null ? "" : `${number(v, 2)} %`))), texttemplate: "%{text}", hovertemplate: "%{y}, %{x}: %{z:.3g} %<extra></extra>", colorbar: { thickness: 10, title: { text: "%" } } }],
        layout: layout(look, { showlegend: false, xaxis: axis(look, "", { side: "top", type: "category" }), yaxis: axis(look, "", { autorange: "reversed", type: "category" }) }) }) });
  }
  const s = result.sections;
  const a = unitFor("length", s.at(-1).arc);
  add({ id: "sections", title: "Sections along the axis", n: s.length, source, say: "Area and second moments of the sections, over their largest values.",
    numbers: () => ({ columns: ["arc [m]", "area [m^2]", "I1 [m^4]", "I2 [m^4]", "torsion constant [m^4]"], rows: s.map((x) => [x.arc, x.area, ...x.second_moments, x.torsion_constant]) }),
    draw(look) {
      const curve = (name, f, color) => { const v = s.map(f); const top = Math.max(...v); return { type: "scatter", mode: "lines", name: plain(name(top)), x: s.map((x) => x.arc / a.factor), y: v.map((x) => x / top), line: { color } }; };
      return { data: [curve((t) => `area, at most ${number(t * 1e6)} mm²`, (x) => x.area, look.refitted), curve((t) => `I1, ${number(t * 1e12)} mm⁴`, (x) => x.second_moments[0], look.held), curve((t) => `I2, ${number(t * 1e12)} mm⁴`, (x) => x.second_moments[1], look.mended), curve((t) => `J, ${number(t * 1e12)} mm⁴`, (x) => x.torsion_constant, look.chosen)],
        layout: layout(look, { xaxis: axis(look, `along the axis [${a.unit}]`), yaxis: axis(look, "over the largest", { range: [0, 1.05] }) }) };
    } });
  return node;
}
