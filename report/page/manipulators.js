// Sections of stiffness, deflect, assemble, trace, map and compensate.
import { choice, element, list, plain, slider } from "./dom.js";
import { Figure } from "./figure.js";
import { axis, layout, rising, scene } from "./look.js";
import { ellipsoid, matrixFigure } from "./matrix.js";
import { extentOf, magnified, skeletonTraces } from "./skeleton.js";
import { number, quantity, unitFor } from "./units.js";
import { View } from "./view.js";
import { roundFactor } from "./workspace.js";

const left = (value, kind) => (value < 1e-12 ? "nothing beyond rounding" : quantity(value, kind));
const norm = (v) => Math.hypot(...v);

function section(name, ...about) {
  const charts = element("div", { class: "charts" });
  const node = element("section", {}, element("h2", {}, name), ...about, charts);
  return { node, add: (spec, view) => charts.append(new Figure(spec, view).node) };
}

const headingOf = (result) => `${result.command ?? "result"}: ${result.inputs?.name ?? ""}`;
const sourceOf = (result) => `Source: ${result.inputs?.robot?.file ?? result.inputs?.name ?? "result"}.`;

/** The state whose matrices are shown: loaded before unloaded. */
const stateOf = (result) => result.loaded ?? result.equilibrium ?? result.assembly?.assembled ?? null;

function skeletonFigure(result, skeletons, view, source) {
  const [from, to] = [skeletons[0], skeletons.at(-1)];
  const size = extentOf(skeletons);
  const shift = Math.max(...to.bodies.map((b, k) => norm(b.position.map((x, i) => x - from.bodies[k].position[i]))), 1e-12);
  const moved = skeletons.length > 1;
  const start = moved ? Math.max(1, roundFactor((0.08 * size) / shift)) : 1;
  const compliance = (stateOf(result)?.compliance ?? result.unloaded?.compliance)?.matrix;
  const longest = compliance ? Math.max(...[0, 1, 2].map((k) => norm(compliance[k].slice(0, 3)))) : 0;
  const scale = compliance ? roundFactor((0.12 * size) / longest) : 0;
  const points = to.chains.flatMap((c) => c.joints.map((j) => [c.name, j.name, j.role, ...j.at]));
  return {
    id: `skeleton-${result.command}`, title: moved ? `Posture, ${from.name} and ${to.name}` : "Posture", n: points.length, source, height: 560, wide: true, heavy: true, follows: ["magnify"],
    say: `${to.chains.length} chains, their joints and frames${moved ? `; grey: ${from.name}; the platform moves ${quantity(shift, "length")}, shown ${number(start)} times at first` : ""}${compliance ? `; ellipsoid: where the platform goes under ${quantity(scale, "force")} in every direction (compliance, so long is soft)` : ""}.`,
    controls: moved ? [slider("Magnification", { from: -1, to: 1, step: 0.05, value: 0, show: (v) => `${number(start * 10 ** v)} times` }, (v) => view.set({ magnify: start * 10 ** v }))] : [],
    numbers: () => ({ columns: ["chain", "joint", "role", "x [m]", "y [m]", "z [m]"], rows: points }),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const shown = moved ? magnified(from, to, view.get("magnify") ?? start) : to;
      const data = skeletonTraces(shown, look, factor);
      if (moved) data.push(...skeletonTraces(from, look, factor, { faint: true, name: from.name }));
      if (compliance) data.push(ellipsoid(compliance, shown.bodies[0].position, scale, factor, look.held));
      return { data, layout: layout(look, { margin: { l: 0, r: 0, t: 30, b: 0 }, scene: scene(look, unit) }) };
    },
  };
}

function wrenchFigure(result, source) {
  const chains = stateOf(result).chains;
  const most = (key) => Math.max(...chains.map((c) => norm(c.wrench[key])), 0);
  const [f, m] = [unitFor("force", most("force")), unitFor("moment", most("moment"))];
  return {
    id: `wrenches-${result.command}`, title: "What each chain carries", n: chains.length, source, say: "Force and moment of the platform on the end of each chain, base axes.",
    numbers: () => ({ columns: ["chain", "Fx [N]", "Fy [N]", "Fz [N]", "Mx [N m]", "My [N m]", "Mz [N m]"], rows: chains.map((c) => [c.name, ...c.wrench.force, ...c.wrench.moment]) }),
    draw: (look) => ({
      data: ["x", "y", "z"].flatMap((name, k) => [["force", f, "x", "y", "F"], ["moment", m, "x2", "y2", "M"]].map(([key, u, xaxis, yaxis, letter]) => ({ type: "bar", name, legendgroup: name, showlegend: key === "force", xaxis, yaxis, x: chains.map((c) => plain(c.name)),
        y: chains.map((c) => c.wrench[key][k] / u.factor), marker: { color: [look.refitted, look.held, look.mended][k] }, hovertemplate: `${letter}${name} = %{y:.4g} ${u.unit}<extra>%{x}</extra>` }))),
      layout: layout(look, { grid: { rows: 1, columns: 2, pattern: "independent" }, barmode: "group", xaxis: axis(look, "", { type: "category" }), xaxis2: axis(look, "", { type: "category" }), yaxis: axis(look, `force [${f.unit}]`), yaxis2: axis(look, `moment [${m.unit}]`) }),
    }),
  };
}

export const isPosture = ({ result }) => result.posture !== undefined && (result.unloaded || result.equilibrium || result.assembly);

export function postureSection({ result, picture }) {
  const state = stateOf(result);
  const sentences = [...(result.unloaded?.free_motions ?? []), ...(result.unloaded?.rigid_directions ?? [])];
  const stability = state?.stability?.platform_free;
  if (stability) sentences.unshift(stability.stable ? "Under this load the platform stands stably." : `Under this load the platform is unstable in ${stability.unstable_directions} directions.`);
  if (state?.displacement) sentences.unshift(`The platform moves ${quantity(norm(state.displacement.translation), "length")} and turns ${quantity(norm(state.displacement.rotation), "angle")}; elastic energy ${number(state.energy)} J.`);
  const { node, add } = section(headingOf(result), list(sentences));
  const view = new View({});
  const source = sourceOf(result);
  if (picture?.skeletons) add(skeletonFigure(result, picture.skeletons, view, source), view);
  for (const [word, matrices] of [["unloaded", result.unloaded], ["loaded", state]])
    for (const what of ["stiffness", "compliance"])
      if (matrices?.[what]) add(matrixFigure(what, { matrix: matrices[what].matrix, id: `${word}-${what}-${result.command}`, title: `${word === "loaded" && result.assembly ? "Assembled" : word[0].toUpperCase() + word.slice(1)} ${what}` }, source), view);
  if (state?.chains?.length > 1) add(wrenchFigure(result, source), view);
  return node;
}

export const isPath = ({ result }) => Array.isArray(result.path?.branches);

// Runs of points [index, deflection and force] that are alike in stability; neighbours meet in the critical point
// between them.
function runs(points, b, critical) {
  const found = [];
  points.forEach((point, k) => {
    if (!point.along) return;
    const last = found.at(-1);
    if (last && last.stable === point.stable) last.members.push([k, point.along]);
    else {
      const between = critical.find((c) => c.branch === b && c.after_point === k - 1 && c.point.along);
      const joint = between ? [k - 1, between.point.along] : last?.members.at(-1);
      if (last && between) last.members.push(joint);
      found.push({ stable: point.stable, members: joint ? [joint, [k, point.along]] : [[k, point.along]] });
    }
  });
  return found;
}

function pathFigure(result, picture, view, source) {
  const { branches, critical_points: critical } = result.path;
  const all = branches.flatMap((b) => b.points).filter((p) => p.along);
  const turns = picture?.path?.turns;
  const d = unitFor(turns ? "angle" : "length", Math.max(...all.map((p) => Math.abs(p.along.deflection))));
  const f = unitFor(turns ? "moment" : "force", Math.max(...all.filter((p) => p.stable).map((p) => Math.abs(p.along.force)), 1e-9));
  // Branches that nothing stays on can be a thousand times stiffer; at first the rest is in sight.
  const forces = [...all.filter((p) => p.stable), ...critical.slice(0, 1).map((c) => c.point).filter((p) => p.along)].map((p) => p.along.force);
  const room = 0.3 * (Math.max(...forces) - Math.min(...forces)) || 1;
  const flat = branches.flatMap((b, k) => b.points.map((_, i) => [k, i]));
  return {
    id: "path", title: "Force against deflection", n: all.length, source, height: 480, follows: ["at"],
    say: `${branches.length} branches, ${critical.length} critical points. Solid: stable, dashed: unstable; at first what is stable is in sight (double click shows all). Choose a point to see the posture there; arrow keys step along.`,
    choose: (point) => { if (point.customdata) view.set({ at: point.customdata }); },
    step: (by) => { const at = view.get("at"); const k = flat.findIndex(([b, i]) => b === at[0] && i === at[1]); view.set({ at: flat[(k + by + flat.length) % flat.length] }); },
    numbers: () => ({ columns: ["branch", "parameter", "stable", "deflection [m or rad]", "force [N or N m]", "stiffness"], rows: branches.flatMap((b, k) => b.points.filter((p) => p.along).map((p) => [k + 1, p.parameter, p.stable ? 1 : 0, p.along.deflection, p.along.force, p.along.stiffness])) }),
    draw(look) {
      const data = branches.flatMap((branch, b) => runs(branch.points, b, critical).map(({ stable, members }) => ({ type: "scatter", mode: "lines+markers", showlegend: false, x: members.map(([, at]) => at.deflection / d.factor), y: members.map(([, at]) => at.force / f.factor),
        customdata: members.map(([i]) => [b, i]), line: { color: stable ? look.good : look.bad, width: 2, dash: stable ? "solid" : "dash" }, marker: { size: 4, color: stable ? look.good : look.bad }, hovertemplate: `branch ${b + 1}, ${stable ? "stable" : "unstable"}<br>%{x:.4g} ${d.unit}, %{y:.4g} ${f.unit}<extra></extra>` })));
      for (const [name, dash, color] of [["stable", "solid", look.good], ["unstable", "dash", look.bad]]) data.push({ type: "scatter", mode: "lines", name, x: [null], y: [null], line: { color, dash } });
      const known = critical.filter((c) => c.point.along);
      data.push({ type: "scatter", mode: "markers", name: "critical points", meta: "guide", x: known.map((c) => c.point.along.deflection / d.factor), y: known.map((c) => c.point.along.force / f.factor), marker: { symbol: "diamond", size: 10, color: look.held, line: { color: look.paper, width: 1 } },
        text: known.map((c) => plain(`${c.kind}, unstable directions ${c.unstable_before} to ${c.unstable_after}`)), hovertemplate: `%{text}<br>%{x:.5g} ${d.unit}, %{y:.5g} ${f.unit}<extra></extra>` });
      const [b, i] = view.get("at");
      const here = branches[b].points[i]?.along;
      if (here) data.push({ type: "scatter", mode: "markers", name: "cursor", meta: "guide", x: [here.deflection / d.factor], y: [here.force / f.factor], marker: { symbol: "circle-open", size: 15, color: look.chosen, line: { width: 3 } }, hoverinfo: "skip" });
      return { data, layout: layout(look, { xaxis: axis(look, `deflection [${d.unit}]`), yaxis: axis(look, `${turns ? "moment" : "force"} [${f.unit}]`, { range: [(Math.min(...forces) - room) / f.factor, (Math.max(...forces) + room) / f.factor] }) }) };
    },
  };
}

function cursorFigure(result, lines, view, source) {
  const points = lines.flat(3);
  const bounds = [0, 1, 2].map((k) => [Math.min(...points.map((p) => p[k])), Math.max(...points.map((p) => p[k]))]);
  const { factor, unit } = unitFor("length", Math.max(...bounds.map(([a, b]) => b - a)));
  const room = Math.max(...bounds.map(([a, b]) => b - a)) * 0.05;
  return {
    id: "path-posture", title: "Posture at the cursor", n: lines.flat().length, source, height: 480, heavy: true, follows: ["at"], say: "The chains, springs deflected to scale; grey: where the path begins.",
    numbers: () => ({ columns: ["chain", "x [m]", "y [m]", "z [m]"], rows: lines[view.get("at")[0]][view.get("at")[1]].flatMap((chain, c) => chain.map((p) => [c + 1, ...p])) }),
    draw(look) {
      const [b, i] = view.get("at");
      const draw = (chains, color, width, name) => chains.map((chain, c) => ({ type: "scatter3d", mode: "lines+markers", name, showlegend: c === 0, x: chain.map((p) => p[0] / factor), y: chain.map((p) => p[1] / factor), z: chain.map((p) => p[2] / factor), line: { color, width }, marker: { size: 2.5, color }, hoverinfo: "skip" }));
      const range = (k) => ({ range: [(bounds[k][0] - room) / factor, (bounds[k][1] + room) / factor] });
      const box = scene(look, unit);
      ["xaxis", "yaxis", "zaxis"].forEach((name, k) => Object.assign(box[name], range(k)));
      return { data: [...draw(lines[0][0], look.noise, 3, "start"), ...draw(lines[b][i], look.refitted, 6, "at the cursor")], layout: layout(look, { margin: { l: 0, r: 0, t: 30, b: 0 }, scene: box }) };
    },
  };
}

export function pathSection({ result, picture }) {
  const first = result.path.critical_points.find((c) => c.point.along);
  const said = [];
  if (first) said.push(`First critical point: ${first.kind} at ${quantity(first.point.along.force, picture?.path?.turns ? "moment" : "force", 4)}.`);
  if (result.segments?.estimate) said.push(`For the distributed beam Richardson's estimate is ${quantity(result.segments.estimate, "force", 4)}; this model is ${number(100 * result.segments.error_as_given, 2)} % off.`);
  const { node, add } = section(headingOf(result), list(said));
  const view = new View({ at: [0, 0] });
  add(pathFigure(result, picture, view, sourceOf(result)), view);
  if (picture?.path?.lines) add(cursorFigure(result, picture.path.lines, view, sourceOf(result)), view);
  return node;
}

export const isMap = ({ result }) => Array.isArray(result.indices) && result.poses !== undefined;

export function mapSection({ result, picture }) {
  const counts = Object.entries(result.states).filter(([, n]) => n > 0).map(([state, n]) => `${n} ${state}`).join(", ");
  const { node, add } = section(headingOf(result), list([`${result.poses} poses: ${counts}.`]));
  if (!picture?.map) return node;
  const { shape, positions, indices, states, length } = picture.map;
  const view = new View({ index: 0, slice: 0 });
  const unique = (k) => [...new Set(positions.map((p) => p[k]))].sort((a, b) => a - b);
  const axes = [0, 1, 2].map(unique);
  const isGrid = shape[3] * shape[4] * shape[5] === 1 && axes.reduce((n, a) => n * a.length, 1) === positions.length;
  const varying = [0, 1, 2].filter((k) => axes[k].length > 1);
  const source = sourceOf(result);
  const index = () => indices[view.get("index")];
  const ends = () => { const v = index().values.filter((x) => x !== null); return [Math.min(...v), Math.max(...v)]; };
  const label = () => `${index().name}${index().unit ? ` [${index().unit}]` : ""}`;
  node.append(element("div", { class: "tools" }, choice("Index", indices.map((x, k) => [k, x.name]), 0, (v) => view.set({ index: Number(v) })),
    isGrid && varying.length === 3 ? choice("Slice z", axes[2].map((z, k) => [k, `${number(z)} ${length}`]), 0, (v) => view.set({ slice: Number(v) })) : null));
  node.append(node.querySelector(".charts"));
  const rows = () => positions.map((p, i) => [...p, states[i], ...indices.map((x) => x.values[i])]);
  const numbers = () => ({ columns: [`x [${length}]`, `y [${length}]`, `z [${length}]`, "state", ...indices.map((x) => `${x.name} [${x.unit}]`)], rows: rows() });
  const step = (by) => { if (varying.length === 3) view.set({ slice: (view.get("slice") + by + axes[2].length) % axes[2].length }); };
  if (isGrid && varying.length >= 2) {
    const [a, b] = varying;
    const at = new Map(positions.map((p, i) => [p.join(), i]));
    add({ id: "map-slice", title: "Slice of the workspace", n: positions.length, source, height: 460, follows: ["index", "slice"], step, numbers,
      say: `Colours are the same in all slices. Blank: no value there (unreachable, no equilibrium).${varying.length === 3 ? " Arrow keys change the slice." : ""}`,
      draw(look) {
        const fixed = [...axes.map((x) => x[0])];
        if (varying.length === 3) fixed[2] = axes[2][view.get("slice")];
        const value = (x, y) => { const p = [...fixed]; p[a] = x; p[b] = y; return index().values[at.get(p.join())]; };
        const [low, high] = ends();
        return { data: [{ type: axes[a].length > 6 && axes[b].length > 6 ? "contour" : "heatmap", x: axes[a], y: axes[b], z: axes[b].map((y) => axes[a].map((x) => value(x, y) ?? null)), zmin: low, zmax: high, colorscale: "Viridis", ...(axes[a].length > 6 ? { contours: { coloring: "heatmap", showlabels: true, labelfont: { size: 10, color: "#fff" } }, ncontours: 14, autocontour: true } : {}),
          colorbar: { title: { text: plain(label()), side: "right" }, thickness: 12 }, hovertemplate: "%{x}, %{y}: %{z:.5g}<extra></extra>" }],
          layout: layout(look, { showlegend: false, xaxis: axis(look, `${"xyz"[a]} [${length}]`, { constrain: "domain" }), yaxis: axis(look, `${"xyz"[b]} [${length}]`, { scaleanchor: "x", constrain: "domain" }) }) };
      } }, view);
  }
  add({ id: "map-space", title: "Over the workspace", n: positions.length, source, height: 460, heavy: true, follows: ["index"], numbers, say: "Every pose, coloured by the index; crosses have no value.",
    draw(look) {
      const good = positions.map((_, i) => i).filter((i) => index().values[i] !== null);
      const bad = positions.map((_, i) => i).filter((i) => index().values[i] === null);
      const place = (members) => ({ x: members.map((i) => positions[i][0]), y: members.map((i) => positions[i][1]), z: members.map((i) => positions[i][2]) });
      const [low, high] = ends();
      return { data: [{ type: "scatter3d", mode: "markers", ...place(good), marker: { size: 4, color: good.map((i) => index().values[i]), cmin: low, cmax: high, colorscale: "Viridis", colorbar: { title: { text: plain(label()), side: "right" }, thickness: 12 } }, hovertemplate: "%{x}, %{y}, %{z}: %{marker.color:.5g}<extra></extra>" },
        { type: "scatter3d", mode: "markers", ...place(bad), marker: { size: 3, symbol: "x", color: look.bad }, text: bad.map((i) => plain(states[i])), hovertemplate: "%{x}, %{y}, %{z}: %{text}<extra></extra>" }],
        layout: layout(look, { showlegend: false, margin: { l: 0, r: 0, t: 30, b: 0 }, scene: scene(look, length) }) };
    } }, view);
  return node;
}

export const isCompensation = ({ result }) => result.command === "compensate" && Array.isArray(result.points);

export function compensationSection({ result }) {
  const source = sourceOf(result);
  const { node, add } = section(headingOf(result), list([`Largest error of position ${quantity(result.error.largest_translation, "length")} before, ${left(result.residual.largest_translation, "length")} after; of rotation ${quantity(result.error.largest_rotation, "angle")} before, ${left(result.residual.largest_rotation, "angle")} after.`]));
  const points = result.points.map((p, k) => ({ ...p, k: k + 1 })).filter((p) => p.error);
  for (const [title, kind, first] of [["position", "length", 0], ["rotation", "angle", 3]]) {
    const size = (p, key) => norm(p[key].slice(first, first + 3));
    const { factor, unit } = unitFor(kind, Math.max(...points.map((p) => size(p, "error"))));
    const noise = kind === "length" ? 1e-12 : 1e-12;
    add({ id: `compensation-${title}`, title: `Error of ${title} along the path`, n: points.length, source, say: "Of the platform, without and with the corrected targets. What is not there is below rounding.",
      numbers: () => ({ columns: ["pose", `before [${kind === "length" ? "m" : "rad"}]`, "after"], rows: points.map((p) => [p.k, size(p, "error"), size(p, "residual")]) }),
      draw: (look) => ({
        data: [["before", "error", look.designed], ["after", "residual", look.mended]].map(([name, key, color]) => ({ type: "scatter", mode: "lines+markers", name, x: points.map((p) => p.k), y: points.map((p) => (size(p, key) > noise ? size(p, key) / factor : 0)), line: { color }, marker: { color, size: 6 } })),
        layout: layout(look, { xaxis: axis(look, "pose of the path"), yaxis: axis(look, `error [${unit}]`, { rangemode: "tozero" }) }),
      }) });
  }
  return node;
}
