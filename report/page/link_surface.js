// The surface of a link with its interfaces, deformed by unit loads.
import { choice, copy, element, plain, slider } from "./dom.js";
import { layout, scene } from "./look.js";
import { number, quantity, unitFor } from "./units.js";
import { roundFactor } from "./workspace.js";

// Which face is chosen, its selector for a link file, and a button that copies it.
function faceControls(surface, view) {
  const faces = surface.faces ?? [];
  const said = element("output", { class: "selector", role: "status" });
  const take = async (face) => {
    if (!(face >= 0)) return;
    view.set({ face });
    const text = faces[face];
    said.textContent = (await copy(text)) ? `copied: ${text}` : text;
  };
  const picker = choice(
    "Face",
    [[-1, "click on one, or choose"], ...faces.map((text, k) => [k, text])],
    -1,
    (v) => view.set({ face: Number(v) }),
  );
  view.listen((keys) => {
    if (keys.includes("face")) picker.querySelector("select").value = String(view.get("face"));
  });
  const button = element(
    "button",
    { type: "button", onclick: () => take(view.get("face")) },
    "Copy selector",
  );
  return { take, nodes: faces.length > 0 ? [element("p", { class: "faces" }, picker, " ", button, " ", said)] : [] };
}

/** Points of a surface [m], how many there are, and how large it is along its longest axis. */
function extentOfSurface(surface) {
  const count = surface.points.length / 3;
  const p = (i, k) => surface.points[3 * i + k] * surface.point_unit;
  const range = [0, 1, 2].map((k) => {
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < count; ++i) {
      low = Math.min(low, p(i, k));
      high = Math.max(high, p(i, k));
    }
    return high - low;
  });
  return { count, p, size: Math.max(...range) };
}

/** Some of its triangles, with their corners at x, y, z. */
function trianglesOf(surface, [x, y, z], members, extra) {
  const corners = (k) => members.map((t) => surface.triangles[3 * t + k]);
  return {
    type: "mesh3d",
    x,
    y,
    z,
    i: corners(0),
    j: corners(1),
    k: corners(2),
    flatshading: true,
    hoverinfo: "none",
    lighting: {
      ambient: 0.7,
      diffuse: 0.6,
      specular: 0.1,
      facenormalsepsilon: 0,
      vertexnormalsepsilon: 0,
    },
    ...extra,
  };
}

const faceOf = (surface) => (t) => surface.of_face?.[t] ?? -1;

/** Some triangles, a trace for each face: a click says which trace it met. The chosen one stands out. */
const tracesByFace = (surface, at, members, view, look, { color, name, group }) =>
  [...new Set(members.map(faceOf(surface)))].map((face, k) =>
    trianglesOf(
      surface,
      at,
      members.filter((t) => faceOf(surface)(t) === face),
      {
        color: face >= 0 && face === view.get("face") ? look.good : color,
        name: plain(name),
        legendgroup: String(group),
        showlegend: k === 0,
        face,
      },
    ),
  );

/** The surface that was checked, with the facets that its defects are of. */
export function checkedSurfaceFigure(surface, view, source) {
  const { count, p, size } = extentOfSurface(surface);
  const faces = faceControls(surface, view);
  const has = (t) => surface.of_defect[t] ?? -1;
  const defects = surface.defects.map((name, d) => [name, surface.of_defect.filter((of) => of === d).length]);
  const broken = defects.length > 0;
  return {
    id: "surface",
    title: broken ? "Where the surface is broken" : "The surface",
    n: count,
    source,
    height: 560,
    wide: true,
    heavy: true,
    follows: ["face"],
    choose: (point) => faces.take(point.data.face),
    say: `${broken ? "Coloured: facets that a defect is of. " : ""}A click on a face copies its selector for the link file.`,
    controls: faces.nodes,
    numbers: () =>
      broken
        ? { columns: ["defect", "facets shown"], rows: defects }
        : { columns: ["x [m]", "y [m]", "z [m]"], rows: Array.from({ length: count }, (_, i) => [0, 1, 2].map((k) => p(i, k))) },
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const at = [0, 1, 2].map((k) => Array.from({ length: count }, (_, i) => p(i, k) / factor));
      const every = surface.of_defect.map((_, t) => t);
      const palette = [look.bad, look.held, "#8a4fbf", "#b0136f"];
      const of = (d) => every.filter((t) => has(t) === d);
      return {
        data: [
          ...tracesByFace(surface, at, of(-1), view, look, { color: "#9fb0c2", name: broken ? "sound facets" : "surface", group: -1 }),
          ...surface.defects
            .map((name, d) => trianglesOf(surface, at, of(d), { color: palette[d % palette.length], name: plain(name), showlegend: true }))
            .filter((trace) => trace.i.length > 0),
        ],
        layout: layout(look, { margin: { l: 0, r: 0, t: 30, b: 0 }, scene: scene(look, unit) }),
      };
    },
  };
}

export function surfaceFigure(surface, view, source) {
  const { count, p, size } = extentOfSurface(surface);
  const shape = () => surface.shapes[view.get("shape")];
  const largest = () => {
    let most = 0;
    const s = shape().displacements;
    for (let i = 0; i < s.length; i += 3)
      most = Math.max(most, Math.hypot(s[i], s[i + 1], s[i + 2]));
    return most * shape().unit;
  };
  const standard = () => roundFactor((0.12 * size) / largest());
  const faces = faceControls(surface, view);
  const colours = (look) => ["#9fb0c2", look.bad, look.held, "#8a4fbf", "#12805c", "#b0136f"];
  const names = [
    "free surface",
    ...surface.interfaces.map(({ name }, k) => {
      const word = k === 0 ? "fixed" : "loaded";
      return name === word ? word : `${word}: ${name}`;
    }),
  ];
  const size_of = (i) => {
    const s = shape();
    return (
      Math.hypot(s.displacements[3 * i], s.displacements[3 * i + 1], s.displacements[3 * i + 2]) *
      s.unit
    );
  };
  return {
    id: "surface",
    title: "The link and how it deforms",
    n: count,
    source,
    height: 560,
    wide: true,
    heavy: true,
    follows: ["shape", "scale", "paint", "face"],
    choose: (point) => faces.take(point.data.face),
    say: "Fixed interface red, loaded one orange. Deformed by one unit load at the reference point of the loaded interface, as many times larger as the slider says. A click on a face copies its selector for the link file.",
    controls: [
      choice(
        "Unit load",
        surface.shapes.map((s, k) => [k, `${s.load} = 1 ${/M/.test(s.load) ? "N m" : "N"}`]),
        0,
        (v) => view.set({ shape: Number(v) }),
      ),
      " ",
      slider(
        "Deformation",
        { from: 0, to: 3, step: 0.05, value: 1, show: (v) => `${number(v)} x standard` },
        (v) => view.set({ scale: v }),
      ),
      " ",
      choice(
        "Colour",
        [
          ["interface", "interfaces"],
          ["size", "displacement"],
        ],
        "interface",
        (v) => view.set({ paint: v }),
      ),
      ...faces.nodes,
    ],
    numbers: () => ({
      columns: ["x [m]", "y [m]", "z [m]", "ux [m]", "uy [m]", "uz [m]"],
      rows: Array.from({ length: count }, (_, i) =>
        [0, 1, 2]
          .map((k) => p(i, k))
          .concat([0, 1, 2].map((k) => shape().displacements[3 * i + k] * shape().unit)),
      ),
    }),
    draw(look) {
      const { factor, unit } = unitFor("length", size);
      const magnify = standard() * view.get("scale");
      const s = shape();
      const at = [0, 1, 2].map((k) =>
        Array.from(
          { length: count },
          (_, i) => (p(i, k) + magnify * s.displacements[3 * i + k] * s.unit) / factor,
        ),
      );
      const palette = colours(look);
      const every = surface.of_interface.map((_, t) => t);
      const u = unitFor("length", largest());
      const data =
        view.get("paint") === "size"
          ? [
              trianglesOf(surface, at, every, {
                intensity: Array.from({ length: count }, (_, i) => size_of(i) / u.factor),
                colorscale: "Viridis",
                colorbar: {
                  title: { text: `displacement [${u.unit}]`, side: "right" },
                  thickness: 12,
                },
              }),
            ]
          : names.flatMap((name, tag) => {
              const own = every.filter((t) => surface.of_interface[t] === tag);
              return tracesByFace(surface, at, own, view, look, { color: palette[tag % palette.length], name, group: tag });
            });
      return {
        data,
        layout: layout(look, {
          margin: { l: 0, r: 0, t: 30, b: 0 },
          scene: scene(look, unit),
          annotations: [
            {
              text: `shown ${number(magnify)} times; largest displacement ${quantity(largest(), "length")}`,
              showarrow: false,
              xref: "paper",
              yref: "paper",
              x: 0,
              y: 0,
              xanchor: "left",
              yanchor: "bottom",
            },
          ],
        }),
      };
    },
  };
}
