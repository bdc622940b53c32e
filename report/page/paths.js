// Section of trace: force against deflection, and the posture at the cursor.
import { list, plain } from "./dom.js";
import { axis, layout, scene } from "./look.js";
import { largest, range } from "./numbers.js";
import { headingOf, section, sourceOf } from "./section.js";
import { budgetOf } from "./uncertainty.js";
import { number, quantity, unitFor } from "./units.js";
import { View } from "./view.js";

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
      const between = critical.find(
        (c) => c.branch === b && c.after_point === k - 1 && c.point.along,
      );
      const joint = between ? [k - 1, between.point.along] : last?.members.at(-1);
      if (last && between) last.members.push(joint);
      found.push({
        stable: point.stable,
        members: joint ? [joint, [k, point.along]] : [[k, point.along]],
      });
    }
  });
  return found;
}

const scatter = (name, more) => ({ type: "scatter", mode: "markers", name, ...more });

/** Branches in runs of equal stability, and two empty traces for the legend. */
function branchTraces(path, units, look) {
  const style = (stable) => ({
    line: { color: stable ? look.good : look.bad, width: 2, dash: stable ? "solid" : "dash" },
    marker: { size: 4, color: stable ? look.good : look.bad },
  });
  const one = (b, { stable, members }) =>
    scatter("", {
      mode: "lines+markers",
      showlegend: false,
      x: members.map(([, at]) => at.deflection / units.d.factor),
      y: members.map(([, at]) => at.force / units.f.factor),
      customdata: members.map(([i]) => [b, i]),
      ...style(stable),
      hovertemplate: `branch ${b + 1}, ${stable ? "stable" : "unstable"}<br>%{x:.4g} ${units.d.unit}, %{y:.4g} ${units.f.unit}<extra></extra>`,
    });
  const legend = [true, false].map((stable) =>
    scatter(stable ? "stable" : "unstable", {
      mode: "lines",
      x: [null],
      y: [null],
      ...style(stable),
    }),
  );
  const traces = path.branches.flatMap((branch, b) =>
    runs(branch.points, b, path.critical_points).map((run) => one(b, run)),
  );
  return [...traces, ...legend];
}

function criticalTrace(path, units, look) {
  const known = path.critical_points.filter((c) => c.point.along);
  const words = (c) => `${c.kind}, unstable directions ${c.unstable_before} to ${c.unstable_after}`;
  return scatter("critical points", {
    meta: "guide",
    x: known.map((c) => c.point.along.deflection / units.d.factor),
    y: known.map((c) => c.point.along.force / units.f.factor),
    marker: {
      symbol: "diamond",
      size: 10,
      color: look.held,
      line: { color: look.paper, width: 1 },
    },
    text: known.map((c) => plain(words(c))),
    hovertemplate: `%{text}<br>%{x:.5g} ${units.d.unit}, %{y:.5g} ${units.f.unit}<extra></extra>`,
  });
}

function cursorTrace(path, [b, i], units, look) {
  const here = path.branches[b].points[i]?.along;
  return scatter("cursor", {
    meta: "guide",
    x: here ? [here.deflection / units.d.factor] : [],
    y: here ? [here.force / units.f.factor] : [],
    marker: { symbol: "circle-open", size: 15, color: look.chosen, line: { width: 3 } },
    hoverinfo: "skip",
  });
}

// Branches that nothing stays on can be a thousand times stiffer; at first the rest is in sight.
function forcesInSight(path, all) {
  const first = path.critical_points.slice(0, 1).map((c) => c.point);
  const [low, high] = range(
    [...all.filter((p) => p.stable), ...first].map((p) => p.along?.force ?? null),
  );
  const room = 0.3 * (high - low) || 1;
  return [low - room, high + room];
}

function pathNumbers(path) {
  const rows = path.branches.flatMap((branch, b) =>
    branch.points
      .filter((p) => p.along)
      .map((p) => [
        b + 1,
        p.parameter,
        p.stable ? 1 : 0,
        p.along.deflection,
        p.along.force,
        p.along.stiffness,
      ]),
  );
  const along = ["deflection [m or rad]", "force [N or N m]", "stiffness"];
  return { columns: ["branch", "parameter", "stable", ...along], rows };
}

function pathFigure(path, turns, view, source) {
  const all = path.branches.flatMap((b) => b.points).filter((p) => p.along);
  const sight = forcesInSight(path, all);
  const units = {
    d: unitFor(turns ? "angle" : "length", largest(all.map((p) => p.along.deflection))),
    f: unitFor(turns ? "moment" : "force", largest(sight)),
  };
  const flat = path.branches.flatMap((b, k) => b.points.map((_, i) => [k, i]));
  return {
    id: "path",
    title: "Force against deflection",
    say: `${path.branches.length} branches, ${path.critical_points.length} critical points. Solid: stable, dashed: unstable; at first what is stable is in sight (double click shows all). Choose a point to see the posture there; arrow keys step along.`,
    n: all.length,
    source,
    height: 480,
    follows: ["at"],
    choose: (point) => {
      if (point.customdata) view.set({ at: point.customdata });
    },
    step(by) {
      const [b, i] = view.get("at");
      const k = flat.findIndex((at) => at[0] === b && at[1] === i);
      view.set({ at: flat[(k + by + flat.length) % flat.length] });
    },
    numbers: () => pathNumbers(path),
    draw: (look) => ({
      data: [
        ...branchTraces(path, units, look),
        criticalTrace(path, units, look),
        cursorTrace(path, view.get("at"), units, look),
      ],
      layout: layout(look, {
        xaxis: axis(look, `deflection [${units.d.unit}]`),
        yaxis: axis(look, `${turns ? "moment" : "force"} [${units.f.unit}]`, {
          range: sight.map((force) => force / units.f.factor),
        }),
      }),
    }),
  };
}

function cursorFigure(result, lines, view, source) {
  const points = lines.flat(3);
  const bounds = [0, 1, 2].map((k) => range(points.map((p) => p[k])));
  const { factor, unit } = unitFor("length", Math.max(...bounds.map(([a, b]) => b - a)));
  const room = Math.max(...bounds.map(([a, b]) => b - a)) * 0.05;
  return {
    id: "path-posture",
    title: "Posture at the cursor",
    n: lines.flat().length,
    source,
    height: 480,
    heavy: true,
    follows: ["at"],
    say: "The chains, springs deflected to scale; grey: where the path starts.",
    numbers: () => ({
      columns: ["chain", "x [m]", "y [m]", "z [m]"],
      rows: lines[view.get("at")[0]][view.get("at")[1]].flatMap((chain, c) =>
        chain.map((p) => [c + 1, ...p]),
      ),
    }),
    draw(look) {
      const [b, i] = view.get("at");
      const draw = (chains, color, width, name) =>
        chains.map((chain, c) => ({
          type: "scatter3d",
          mode: "lines+markers",
          name,
          showlegend: c === 0,
          x: chain.map((p) => p[0] / factor),
          y: chain.map((p) => p[1] / factor),
          z: chain.map((p) => p[2] / factor),
          line: { color, width },
          marker: { size: 2.5, color },
          hoverinfo: "skip",
        }));
      const range = (k) => ({
        range: [(bounds[k][0] - room) / factor, (bounds[k][1] + room) / factor],
      });
      const box = scene(look, unit);
      ["xaxis", "yaxis", "zaxis"].forEach((name, k) => Object.assign(box[name], range(k)));
      return {
        data: [
          ...draw(lines[0][0], look.noise, 3, "start"),
          ...draw(lines[b][i], look.fitted, 6, "at the cursor"),
        ],
        layout: layout(look, { margin: { l: 0, r: 0, t: 30, b: 0 }, scene: box }),
      };
    },
  };
}

export function pathSection({ result, picture }) {
  const first = result.path.critical_points.find((c) => c.point.along);
  const said = [];
  if (first)
    said.push(
      `First critical point: ${first.kind} at ${quantity(first.point.along.force, picture?.path?.turns ? "moment" : "force", 4)}.`,
    );
  if (result.segments?.estimate)
    said.push(
      `For the distributed beam Richardson's estimate is ${quantity(result.segments.estimate, "force", 4)}; this model is ${number(100 * result.segments.error_as_given, 2)} % off.`,
    );
  const { node, add } = section(headingOf(result), list(said));
  const view = new View({ at: [0, 0] });
  add(pathFigure(result.path, picture?.path?.turns, view, sourceOf(result)), view);
  if (picture?.path?.lines)
    add(cursorFigure(result, picture.path.lines, view, sourceOf(result)), view);
  node.append(budgetOf(result) ?? "");
  return node;
}
