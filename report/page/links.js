// Section of identify: surface, compliance, bounds of the clamping assumption, convergence.
import { element, list } from "./dom.js";
import { Figure } from "./figure.js";
import { checkedSurfaceFigure, surfaceFigure } from "./link_surface.js";
import { axis, layout } from "./look.js";
import { matrixFigure } from "./matrix.js";
import { number, quantity } from "./units.js";
import { View } from "./view.js";

export const motions = ["tx", "ty", "tz", "rx", "ry", "rz"];
const isLinkMatrix = (m) => Array.isArray(m) && m.length === 6;
export const isLink = ({ result }) => isLinkMatrix(result.compliance) && result.link !== undefined;

function bracketFigure(result, source) {
  const { rigid, distributing } = result.bracket;
  const entries = motions.map((name, k) => [
    name,
    rigid[k][k],
    distributing[k][k],
    result.compliance[k][k],
  ]);
  const low = (e) => 100 * (e[1] / e[3] - 1);
  const high = (e) => 100 * (e[2] / e[3] - 1);
  return {
    id: "bracket",
    title: "Effect of the clamping assumption: lower and upper bound",
    n: 6,
    source,
    say: "Compliance with all interfaces rigid (lower bound) and distributing (upper bound), beside the coupling of the link file: the uncertainty of how the link is clamped.",
    numbers: () => ({
      columns: ["entry", "rigid [SI]", "distributing [SI]", "as in the link file"],
      rows: entries,
    }),
    draw: (look) => ({
      data: [
        ...entries.map((e) => ({
          type: "scatter",
          mode: "lines",
          meta: "guide",
          showlegend: false,
          hoverinfo: "skip",
          x: [low(e), high(e)],
          y: [e[0], e[0]],
          line: { color: look.noise, width: 6 },
        })),
        ...[
          ["rigid", low, look.fitted],
          ["distributing", high, look.held],
        ].map(([name, f, color]) => ({
          type: "scatter",
          mode: "markers",
          name,
          x: entries.map(f),
          y: motions,
          marker: { size: 11, color },
          hovertemplate: "%{y}: %{x:.3g} %<extra></extra>",
        })),
      ],
      layout: layout(look, {
        xaxis: axis(look, "against the link file [%]"),
        yaxis: axis(look, "", { type: "category", autorange: "reversed" }),
      }),
    }),
  };
}

function convergenceFigure(result, source) {
  const meshes = result.error.meshes;
  const errors = [...meshes.map((m) => m.relative_error), result.error.asked].filter((e) => e > 0);
  const decades = Math.log10(Math.max(...errors) / Math.min(...errors));
  return {
    id: "convergence",
    title: "Convergence",
    n: meshes.length,
    source,
    say: `Estimated error of the worst significant entry on each mesh${result.error.asked ? `; asked for: ${number(100 * result.error.asked, 2)} %` : ""}. ${result.error.shortfall || ""}`,
    numbers: () => ({
      columns: ["unknowns", "elements", "estimated relative error"],
      rows: meshes.map((m) => [m.unknowns, m.elements, m.relative_error]),
    }),
    draw: (look) => ({
      data: [
        {
          type: "scatter",
          mode: "lines+markers",
          name: "estimated error",
          x: meshes.map((m) => m.unknowns),
          y: meshes.map((m) => 100 * m.relative_error),
          line: { color: look.fitted },
          marker: { size: 9 },
        },
      ],
      layout: layout(look, {
        showlegend: false,
        xaxis: axis(look, "unknowns", { type: "log" }),
        yaxis: axis(look, "estimated error [%]", { type: "log", dtick: decades < 2 ? "D2" : 1 }),
        shapes: result.error.asked
          ? [
              {
                type: "line",
                xref: "paper",
                x0: 0,
                x1: 1,
                y0: 100 * result.error.asked,
                y1: 100 * result.error.asked,
                line: { color: look.good, dash: "dash" },
              },
            ]
          : [],
      }),
    }),
  };
}

export function linkSection({ result, picture }) {
  const source = `Source: ${result.inputs?.mesh_file ?? result.link}, ${result.mesh ? `${result.mesh.elements} tetrahedra` : "no mesh"}.`;
  const said = [
    result.mass ? `Mass ${number(result.mass)} kg.` : null,
    result.error?.relative !== undefined
      ? `Every significant entry is known to ${number(100 * result.error.relative, 2)} %.`
      : null,
    result.eigen_stiffness
      ? `Eigen-stiffnesses ${result.eigen_stiffness.translation.map((v) => quantity(v, "stiffness")).join(", ")}; ${result.eigen_stiffness.rotation.map((v) => quantity(v, "torsion")).join(", ")}.`
      : null,
    ...(result.joints ?? []).map(
      (joint) =>
        `${joint.between.join(" and ")}: ${joint.bonded ? "bonded" : "an elastic layer"} over ${number(1e6 * joint.area)} mm².`,
    ),
    ...(result.warnings ?? []).map((text) => `Warning: ${text}`),
  ].filter(Boolean);
  const charts = element("div", { class: "charts" });
  const node = element(
    "section",
    {},
    element("h2", {}, `Link: ${result.link}`),
    list(said),
    charts,
  );
  const view = new View({ shape: 0, scale: 1, paint: "interface", face: -1 });
  const add = (spec) => charts.append(new Figure(spec, view).node);
  if (picture?.surface?.shapes?.length) add(surfaceFigure(picture.surface, view, source));
  add(
    matrixFigure(
      "compliance",
      {
        matrix: result.compliance,
        bars: isLinkMatrix(result.error?.bar) ? result.error.bar : undefined,
        id: "link-compliance",
        title: "6x6 compliance with error bars",
      },
      source,
    ),
  );
  if (isLinkMatrix(result.bracket?.rigid)) add(bracketFigure(result, source));
  if (result.error?.meshes?.length > 1) add(convergenceFigure(result, source));
  return node;
}

export const isCheckedSurface = ({ result, picture }) => result.command === "mesh check" && Boolean(picture?.surface?.of_defect);

/** A picture of the surface, and what the command printed of it. */
export function checkedSurfaceSection({ result, picture, text }) {
  const source = `Source: ${result.options?.mesh ?? "mesh"}, ${number(result.facets ?? picture.surface.of_defect.length, 6)} facets.`;
  const view = new View({ face: -1 });
  return element(
    "section",
    {},
    element("h2", {}, "The mesh"),
    element("div", { class: "charts" }, new Figure(checkedSurfaceFigure(picture.surface, view, source), view).node),
    text ? element("pre", { tabindex: "0" }, text) : null,
  );
}
