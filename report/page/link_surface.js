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

export function surfaceFigure(surface, view, source) {
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
  const size = Math.max(...range);
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
  const face_of = (t) => surface.of_face?.[t] ?? -1;
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
      const at = (k) =>
        Array.from(
          { length: count },
          (_, i) => (p(i, k) + magnify * s.displacements[3 * i + k] * s.unit) / factor,
        );
      const corners = (k, members) => members.map((t) => surface.triangles[3 * t + k]);
      const palette = colours(look);
      const mesh = (members, extra) => ({
        type: "mesh3d",
        x: at(0),
        y: at(1),
        z: at(2),
        i: corners(0, members),
        j: corners(1, members),
        k: corners(2, members),
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
      });
      const every = surface.of_interface.map((_, t) => t);
      const u = unitFor("length", largest());
      const data =
        view.get("paint") === "size"
          ? [
              mesh(every, {
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
              // One trace for each face: a click says which trace it met.
              return [...new Set(own.map(face_of))].map((face, k) =>
                mesh(
                  own.filter((t) => face_of(t) === face),
                  {
                    color:
                      face >= 0 && face === view.get("face")
                        ? look.good
                        : palette[tag % palette.length],
                    name: plain(name),
                    legendgroup: String(tag),
                    showlegend: k === 0,
                    face,
                  },
                ),
              );
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
