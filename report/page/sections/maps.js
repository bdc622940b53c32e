// Section of map: slices of the workspace, and all of it.
import { choice, element, list, plain, table } from "../dom.js";
import { axis, layout, scene } from "../look.js";
import { range } from "../numbers.js";
import { headingOf, section, sourceOf } from "../section.js";
import { extentOf, skeletonTraces } from "../skeleton.js";
import { asChosen, number, unitFor } from "../units.js";
import { View } from "../view.js";

export const isMap = ({ result }) => Array.isArray(result.indices) && result.poses !== undefined;

/** Poses with the values of the chosen index. */
class PoseMap {
  constructor(picture, view) {
    Object.assign(this, picture);
    this.view = view;
    const { values, unit } = asChosen(this.positions, this.length);
    Object.assign(this, { positions: values, length: unit });
    this.indices = this.indices.map((index) => ({ ...index, ...asChosen(index.values, index.unit) }));
    this.axes = [0, 1, 2].map((k) =>
      [...new Set(this.positions.map((p) => p[k]))].sort((a, b) => a - b),
    );
    this.varying = [0, 1, 2].filter((k) => this.axes[k].length > 1);
    this.numberOf = new Map(this.positions.map((p, i) => [p.join(), i]));
  }
  /** Positions on a grid, without rotations. */
  get isGrid() {
    const [, , , rx, ry, rz] = this.shape;
    const cells = this.axes.reduce((count, values) => count * values.length, 1);
    return rx * ry * rz === 1 && cells === this.positions.length;
  }
  get index() {
    return this.indices[this.view.get("index")];
  }
  get label() {
    return plain(this.index.name + (this.index.unit ? ` [${this.index.unit}]` : ""));
  }
  get ends() {
    return range(this.index.values);
  }
  /** The pose that was picked on the page, with its number; nothing before one was. */
  get picked() {
    const k = this.view.get("pose");
    return k === null ? null : { k, position: this.positions[k] };
  }
  /** In all charts, in the slice that it lies in. */
  pick(k) {
    if (k === undefined) return;
    const slice = k !== null && this.varying.length === 3 ? this.axes[2].indexOf(this.positions[k][2]) : this.view.get("slice");
    this.view.set({ pose: k, slice });
  }
  step(by) {
    const count = this.positions.length;
    this.pick(((this.view.get("pose") ?? (by > 0 ? -1 : 0)) + by + count) % count);
  }
  valueAt(position) {
    return this.index.values[this.numberOf.get(position.join())] ?? null;
  }
  numbers() {
    const names = this.indices.map((index) => `${index.name} [${index.unit}]`);
    return {
      columns: [...["x", "y", "z"].map((name) => `${name} [${this.length}]`), "state", ...names],
      rows: this.positions.map((p, i) => [
        ...p,
        this.states[i],
        ...this.indices.map((index) => index.values[i]),
      ]),
    };
  }
}

const colorbar = (title) => ({ title: { text: title, side: "right" }, thickness: 12 });

function sliceFigure(map, source) {
  const [a, b] = map.varying;
  const inSpace = map.varying.length === 3;
  const smooth = map.axes[a].length > 6 && map.axes[b].length > 6;
  const lines = {
    contours: { coloring: "heatmap", showlabels: true, labelfont: { size: 10, color: "#fff" } },
    ncontours: 14,
    autocontour: true,
  };
  const placeAt = (x, y) => {
    const position = map.axes.map((values) => values[0]);
    if (inSpace) position[2] = map.axes[2][map.view.get("slice")];
    position[a] = x;
    position[b] = y;
    return position;
  };
  const nearest = (values, v) => values.reduce((best, x) => (Math.abs(x - v) < Math.abs(best - v) ? x : best));
  return {
    id: "map-slice",
    title: "Slice of the workspace",
    say: `Colours are the same in all slices. Blank: no value there (unreachable, no equilibrium).${
      inSpace ? " Arrow keys change the slice." : ""
    } A click picks a pose in all charts.`,
    n: map.positions.length,
    source,
    height: 460,
    follows: ["index", "slice", "pose"],
    choose: ({ x, y }) => map.pick(map.numberOf.get(placeAt(nearest(map.axes[a], x), nearest(map.axes[b], y)).join())),
    step(by) {
      const count = map.axes[2].length;
      if (inSpace) map.view.set({ slice: (map.view.get("slice") + by + count) % count });
    },
    numbers: () => map.numbers(),
    draw(look) {
      const [low, high] = map.ends;
      const trace = {
        type: smooth ? "contour" : "heatmap",
        x: map.axes[a],
        y: map.axes[b],
        z: map.axes[b].map((y) => map.axes[a].map((x) => map.valueAt(placeAt(x, y)))),
        zmin: low,
        zmax: high,
        colorscale: "Viridis",
        ...(smooth ? lines : {}),
        colorbar: colorbar(map.label),
        hovertemplate: "%{x}, %{y}: %{z:.5g}<extra></extra>",
      };
      const title = (k) => `${"xyz"[k]} [${map.length}]`;
      const at = map.picked?.position;
      const isHere = at && (!inSpace || at[2] === map.axes[2][map.view.get("slice")]);
      const sign = {
        type: "scatter",
        mode: "markers",
        meta: "guide",
        x: [at?.[a]],
        y: [at?.[b]],
        marker: { size: 16, symbol: "circle-open", color: look.chosen, line: { width: 4 } },
        hoverinfo: "skip",
      };
      return {
        data: isHere ? [trace, sign] : [trace],
        layout: layout(look, {
          showlegend: false,
          xaxis: axis(look, title(a), { constrain: "domain" }),
          yaxis: axis(look, title(b), { scaleanchor: "x", constrain: "domain" }),
        }),
      };
    },
  };
}

function spaceFigure(map, source) {
  const place = (members) => ({
    x: members.map((i) => map.positions[i][0]),
    y: members.map((i) => map.positions[i][1]),
    z: members.map((i) => map.positions[i][2]),
  });
  return {
    id: "map-space",
    title: "Over the workspace",
    say: "Every pose, coloured by the index; crosses have no value. A click picks a pose in all charts; the right and left arrow keys take the next.",
    n: map.positions.length,
    source,
    height: 460,
    heavy: true,
    follows: ["index", "pose"],
    choose: ({ customdata }) => map.pick(customdata),
    step: (by) => map.step(by),
    numbers: () => map.numbers(),
    draw(look) {
      const all = [...map.positions.keys()];
      const known = all.filter((i) => map.index.values[i] !== null);
      const unknown = all.filter((i) => map.index.values[i] === null);
      const [cmin, cmax] = map.ends;
      const color = known.map((i) => map.index.values[i]);
      const values = {
        type: "scatter3d",
        mode: "markers",
        ...place(known),
        customdata: known,
        marker: {
          size: 4,
          color,
          cmin,
          cmax,
          colorscale: "Viridis",
          colorbar: colorbar(map.label),
        },
        hovertemplate: "%{x}, %{y}, %{z}: %{marker.color:.5g}<extra></extra>",
      };
      const gaps = {
        type: "scatter3d",
        mode: "markers",
        ...place(unknown),
        customdata: unknown,
        marker: { size: 3, symbol: "x", color: look.bad },
        text: unknown.map((i) => plain(map.states[i])),
        hovertemplate: "%{x}, %{y}, %{z}: %{text}<extra></extra>",
      };
      const sign = {
        type: "scatter3d",
        mode: "markers",
        meta: "guide",
        ...place(map.picked ? [map.picked.k] : []),
        marker: { size: 12, symbol: "circle-open", color: look.chosen, line: { width: 4 } },
        hoverinfo: "skip",
      };
      return {
        data: map.picked ? [values, gaps, sign] : [values, gaps],
        layout: layout(look, {
          showlegend: false,
          margin: { l: 0, r: 0, t: 30, b: 0 },
          scene: scene(look, map.length),
        }),
      };
    },
  };
}

/** The robot where the pose that was picked wants it; at first where the index is smallest. */
function robotFigure(map, source) {
  const size = extentOf(map.robots.filter(Boolean));
  const robotAt = (k) => map.robots[k];
  const smallest = () => map.index.values.indexOf(map.ends[0]);
  return {
    id: "map-robot",
    title: "The robot at the pose that was picked",
    say: "Before one is picked: where the index is smallest. The right and left arrow keys take the next pose.",
    n: map.robots.filter(Boolean).length,
    source,
    height: 460,
    heavy: true,
    follows: ["index", "pose"],
    step: (by) => map.step(by),
    numbers: () => map.numbers(),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const k = map.picked?.k ?? smallest();
      const robot = robotAt(k);
      const others = map.robots.find(Boolean);
      return {
        data: robot ? skeletonTraces(robot, look, factor) : skeletonTraces(others, look, factor, { faint: true, name: "out of reach" }),
        layout: layout(look, {
          margin: { l: 0, r: 0, t: 0, b: 0 },
          legend: { orientation: "h", y: 0, yanchor: "top", x: 0, font: { size: 12 } },
          scene: scene(look, unit),
        }),
      };
    },
  };
}

/** Every pose by name, those where the index is smallest and largest first. */
function poseChoice(map) {
  const named = (k) => `${map.positions[k].map((x) => number(x)).join(", ")} ${map.length}`;
  const [low, high] = map.ends.map((end) => map.index.values.indexOf(end));
  const options = [
    ["", "none"],
    [low, `smallest: ${named(low)}`],
    [high, `largest: ${named(high)}`],
    ...[...map.positions.keys()].filter((k) => k !== low && k !== high).map((k) => [k, named(k)]),
  ];
  const node = choice("Pose", options, "", (v) => map.pick(v === "" ? null : Number(v)));
  map.view.listen((keys) => {
    if (keys.includes("pose")) node.querySelector("select").value = String(map.view.get("pose") ?? "");
  });
  return node;
}

function sliceChoice(map, slices) {
  const node = choice("Slice z", slices, 0, (v) => map.view.set({ slice: Number(v) }));
  map.view.listen((keys) => {
    if (keys.includes("slice")) node.querySelector("select").value = String(map.view.get("slice"));
  });
  return node;
}

function mapTools(map) {
  const names = map.indices.map((index, k) => [k, index.name]);
  const slices = map.axes[2].map((z, k) => [k, `${number(z)} ${map.length}`]);
  const withSlices = map.isGrid && map.varying.length === 3;
  return element(
    "div",
    { class: "tools" },
    choice("Index", names, 0, (v) => map.view.set({ index: Number(v) })),
    withSlices ? sliceChoice(map, slices) : null,
    map.robots?.length && map.ends.every(Number.isFinite) ? poseChoice(map) : null,
  );
}

/** Of each index where it is smallest and largest, and its mean over the map. */
function extremes(map) {
  const rows = map.indices.flatMap((index) => {
    const known = index.values.flatMap((value, k) => (value === null ? [] : [[value, k]]));
    if (!known.length) return [];
    const [low, high] = range(known.map(([value]) => value));
    const at = (wanted) => {
      const [, k] = known.find(([value]) => value === wanted);
      return `${map.positions[k].map((x) => number(x)).join(", ")} ${map.length}`;
    };
    const mean = known.reduce((total, [value]) => total + value, 0) / known.length;
    const four = (value) => number(value, 4);
    return [[index.name, four(low), at(low), four(mean), four(high), at(high), index.unit]];
  });
  if (!rows.length) return null;
  const columns = ["index", "smallest", "at", "mean", "largest", "at ", "unit"];
  return table(columns, rows, "Smallest, mean and largest over the poses with a value");
}

export function mapSection({ result, picture }) {
  const counts = Object.entries(result.states)
    .filter(([, count]) => count > 0)
    .map(([state, count]) => `${count} ${state}`);
  const said = list([`${result.poses} poses: ${counts.join(", ")}.`]);
  if (!picture?.map) return section(headingOf(result), said).node;
  const view = new View({ index: 0, slice: 0, pose: null });
  const map = new PoseMap(picture.map, view);
  const { node, add } = section(headingOf(result), said, extremes(map), mapTools(map));
  const source = sourceOf(result);
  if (map.isGrid && map.varying.length >= 2) add(sliceFigure(map, source), view);
  add(spaceFigure(map, source), view);
  if (map.robots?.some(Boolean)) add(robotFigure(map, source), view);
  return node;
}
