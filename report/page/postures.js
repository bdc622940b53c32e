// Sections of stiffness, deflect and assemble: a posture before and after, its matrices, what the chains carry.
import { bars } from "./bars.js";
import { list, plain, slider } from "./dom.js";
import { axis, layout, scene } from "./look.js";
import { ellipsoid, matrixFigure } from "./matrix.js";
import { headingOf, norm, section, sourceOf } from "./section.js";
import { extentOf, magnified, skeletonTraces } from "./skeleton.js";
import { budgetOf } from "./uncertainty.js";
import { number, quantity, unitFor } from "./units.js";
import { View } from "./view.js";
import { roundFactor } from "./workspace.js";

/** The state whose matrices are shown: loaded before unloaded. */
const stateOf = (result) =>
  result.loaded ?? result.equilibrium ?? result.assembly?.assembled ?? null;

/** The load as an arrow whose tip is where it acts. */
function loadArrow({ at, force }, size, factor, look) {
  const most = norm(force);
  if (!(most > 0)) return [];
  const start = at.map((x, k) => (x - (0.25 * size * force[k]) / most) / factor);
  const tip = at.map((x) => x / factor);
  const [x, y, z] = [0, 1, 2].map((k) => [start[k], tip[k]]);
  const [u, v, w] = force.map((f) => [f / most]);
  const colour = [
    [0, look.bad],
    [1, look.bad],
  ];
  return [
    {
      type: "scatter3d",
      mode: "lines",
      meta: "guide",
      name: `load ${quantity(most, "force")}`,
      x,
      y,
      z,
      line: { color: look.bad, width: 8 },
      hoverinfo: "name",
    },
    {
      type: "cone",
      meta: "guide",
      x: [tip[0]],
      y: [tip[1]],
      z: [tip[2]],
      u,
      v,
      w,
      anchor: "tip",
      sizemode: "absolute",
      sizeref: (0.08 * size) / factor,
      colorscale: colour,
      showscale: false,
      hoverinfo: "skip",
    },
  ];
}

/** The joint that all this is about. */
function jointSign(skeleton, name, factor, look) {
  const joint = skeleton.chains
    .flatMap((c) => c.joints.map((j) => ({ ...j, full: `${c.name}.${j.name}` })))
    .find((j) => j.full === name || j.name === name);
  if (!joint) return [];
  return [
    {
      type: "scatter3d",
      mode: "markers",
      meta: "guide",
      name: plain(name),
      ...Object.fromEntries(["x", "y", "z"].map((key, k) => [key, [joint.at[k] / factor]])),
      marker: { size: 12, color: look.chosen, symbol: "circle-open", line: { width: 4 } },
      hoverinfo: "name",
    },
  ];
}

/** `load`: {at, force}; `joint`: a name to point at. */
export function skeletonFigure(result, skeletons, view, source, { load, joint } = {}) {
  const [from, to] = [skeletons[0], skeletons.at(-1)];
  const size = extentOf(skeletons);
  const shift = Math.max(
    ...to.bodies.map((b, k) => norm(b.position.map((x, i) => x - from.bodies[k].position[i]))),
  );
  // What only turns about itself has nothing to magnify.
  const moved = shift > 1e-9 * size;
  const start = moved ? Math.max(1, roundFactor((0.08 * size) / shift)) : 1;
  const compliance = (stateOf(result)?.compliance ?? result.unloaded?.compliance)?.matrix;
  const longest = compliance
    ? Math.max(...[0, 1, 2].map((k) => norm(compliance[k].slice(0, 3))))
    : 0;
  const scale = compliance ? roundFactor((0.12 * size) / longest) : 0;
  const said = [
    `${to.chains.length} chain${to.chains.length === 1 ? ", its" : "s, their"} joints and frames`,
  ];
  if (moved)
    said.push(
      `grey: ${from.name}`,
      `bodies move up to ${quantity(shift, "length")}, shown ${number(start)} times at first`,
    );
  if (load && norm(load.force) > 0)
    said.push(`red arrow: the load, ${quantity(norm(load.force), "force")}`);
  if (compliance)
    said.push(
      `ellipsoid: where the platform goes under ${quantity(scale, "force")} in every direction (compliance, so long is soft)`,
    );
  const points = to.chains.flatMap((c) => c.joints.map((j) => [c.name, j.name, j.role, ...j.at]));
  return {
    id: `skeleton-${result.command}`,
    title: moved ? `Posture, ${from.name} and ${to.name}` : "Posture",
    n: points.length,
    source,
    height: 560,
    wide: true,
    heavy: true,
    follows: ["magnify"],
    say: `${said.join("; ")}.`,
    controls: moved
      ? [
          slider(
            "Magnification",
            {
              from: -1,
              to: 1,
              step: 0.05,
              value: 0,
              show: (v) => `${number(start * 10 ** v)} times`,
            },
            (v) => view.set({ magnify: start * 10 ** v }),
          ),
        ]
      : [],
    numbers: () => ({
      columns: ["chain", "joint", "role", "x [m]", "y [m]", "z [m]"],
      rows: points,
    }),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const shown = moved ? magnified(from, to, view.get("magnify") ?? start) : to;
      const data = skeletonTraces(shown, look, factor);
      if (moved) data.push(...skeletonTraces(from, look, factor, { faint: true, name: from.name }));
      if (load) {
        const at = moved
          ? load.at.map(
              (x, k) => x + shown.bodies[0].position[k] - to.bodies[0].position[k],
            )
          : load.at;
        data.push(...loadArrow({ ...load, at }, size, factor, look));
      }
      if (joint) data.push(...jointSign(shown, joint, factor, look));
      if (compliance)
        data.push(ellipsoid(compliance, shown.bodies[0].position, scale, factor, look.held));
      return {
        data,
        layout: layout(look, {
          margin: { l: 0, r: 0, t: 0, b: 0 },
          legend: { orientation: "h", y: 0, yanchor: "top", x: 0, font: { size: 12 } },
          scene: scene(look, unit),
        }),
      };
    },
  };
}

function wrenchFigure(result, source) {
  const chains = stateOf(result).chains;
  const most = (key) => Math.max(...chains.map((c) => norm(c.wrench[key])), 0);
  const [f, m] = [unitFor("force", most("force")), unitFor("moment", most("moment"))];
  return {
    id: `wrenches-${result.command}`,
    title: "What each chain carries",
    n: chains.length,
    source,
    say: "Force and moment of the platform on the end of each chain, base axes.",
    numbers: () => ({
      columns: ["chain", "Fx [N]", "Fy [N]", "Fz [N]", "Mx [N m]", "My [N m]", "Mz [N m]"],
      rows: chains.map((c) => [c.name, ...c.wrench.force, ...c.wrench.moment]),
    }),
    draw: (look) => ({
      data: ["x", "y", "z"].flatMap((name, k) =>
        [
          ["force", f, "x", "y", "F"],
          ["moment", m, "x2", "y2", "M"],
        ].map(([key, u, xaxis, yaxis, letter]) => ({
          type: "bar",
          name,
          legendgroup: name,
          showlegend: key === "force",
          xaxis,
          yaxis,
          x: chains.map((c) => plain(c.name)),
          y: chains.map((c) => c.wrench[key][k] / u.factor),
          marker: { color: [look.fitted, look.held, look.final][k] },
          hovertemplate: `${letter}${name} = %{y:.4g} ${u.unit}<extra>%{x}</extra>`,
        })),
      ),
      layout: layout(look, {
        grid: { rows: 1, columns: 2, pattern: "independent" },
        barmode: "group",
        xaxis: axis(look, "", { type: "category" }),
        xaxis2: axis(look, "", { type: "category" }),
        yaxis: axis(look, `force [${f.unit}]`),
        yaxis2: axis(look, `moment [${m.unit}]`, { side: "right" }),
      }),
    }),
  };
}

/** Which joints and links yield: `result.yields`. */
export function sharesFigure(result, source) {
  const rows = result.yields.filter((one) => one.share >= 0.005);
  const along = result.yields_along ?? "the softest direction";
  return {
    id: `yields-${result.command}`,
    title: "What yields",
    n: rows.length,
    source,
    height: 110 + 32 * rows.length,
    say: `Share of each joint and link in how far the platform yields along ${along}.`,
    numbers: () => ({
      columns: ["joint or link", "share"],
      rows: result.yields.map((one) => [one.spring, one.share]),
    }),
    draw: (look) =>
      bars(look, {
        names: rows.map((one) => plain(one.spring)),
        values: rows.map((one) => 100 * one.share),
        colours: look.fitted,
        text: rows.map((one) => `${number(100 * one.share, 2)} %`),
        hover: rows.map((one) => `${plain(one.spring)}: ${number(100 * one.share)} %`),
        x: { title: "share [%]", rangemode: "tozero" },
      }),
  };
}

export const isPosture = ({ result }) =>
  result.posture !== undefined && (result.unloaded || result.equilibrium || result.assembly);

export function postureSection({ result, picture }) {
  const state = stateOf(result);
  const sentences = [
    ...(result.unloaded?.free_motions ?? []),
    ...(result.unloaded?.rigid_directions ?? []),
  ];
  const stability = state?.stability?.platform_free;
  if (stability)
    sentences.unshift(
      stability.stable
        ? "The platform stands stably."
        : `The platform is unstable in ${stability.unstable_directions} directions.`,
    );
  if (state?.displacement)
    sentences.unshift(
      `The platform moves ${quantity(norm(state.displacement.translation), "length")} and turns ${quantity(norm(state.displacement.rotation), "angle")}; elastic energy ${number(state.energy)} J.`,
    );
  const { node, add } = section(headingOf(result), ...(sentences.length ? [list(sentences)] : []));
  const view = new View({});
  const source = sourceOf(result);
  const yields = result.yields?.length ? sharesFigure(result, source) : null;
  if (picture?.skeletons) {
    const robot = skeletonFigure(result, picture.skeletons, view, source, { load: picture.load });
    add(yields ? { ...robot, wide: false, height: 460 } : robot, view);
  }
  if (yields) add(yields, view);
  for (const [word, matrices] of [
    ["unloaded", result.unloaded],
    ["loaded", state],
  ])
    for (const what of ["stiffness", "compliance"])
      if (matrices?.[what])
        add(
          matrixFigure(
            what,
            {
              matrix: matrices[what].matrix,
              id: `${word}-${what}-${result.command}`,
              title: `${word === "loaded" && result.assembly ? "Assembled" : word[0].toUpperCase() + word.slice(1)} ${what}`,
            },
            source,
          ),
          view,
        );
  if (state?.chains?.length > 1) add(wrenchFigure(result, source), view);
  node.append(budgetOf(result) ?? "");
  return node;
}
