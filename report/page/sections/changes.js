// Section of adopt: the error before and after, and what became of the robot file.
import { bars } from "../bars.js";
import { element, list } from "../dom.js";
import { section } from "../section.js";
import { number } from "../units.js";
import { View } from "../view.js";
import { lineChanges, shownChanges } from "./lines.js";

export const isAdoption = ({ result }) => result.command === "adopt" && Array.isArray(result.adopted);

function errorsFigure(result) {
  const rows = [
    ["held out, before", result.held_out_before],
    ["held out, after", result.held_out_after],
    ["all readings, as written", result.error_as_written],
  ].filter(([, value]) => Number.isFinite(value));
  return {
    id: "adopted-error",
    title: "Error before and after",
    n: rows.length,
    source: `Source: ${result.options?.DIAGNOSIS ?? "the diagnosis"}.`,
    height: 110 + 40 * rows.length,
    say: "rms error, times the noise; dashed: 1, as good as the readings allow.",
    numbers: () => ({ columns: ["error", "times the noise"], rows }),
    draw: (look) =>
      bars(look, {
        names: rows.map(([name]) => name),
        values: rows.map(([, value]) => value),
        colours: rows.map((_, k) => (k === 0 ? look.nominal : look.final)),
        text: rows.map(([, value]) => number(value)),
        hover: rows.map(([name, value]) => `${name}: ${number(value)}`),
        limits: [[1, look.noise, 2]],
        x: { title: "error [times the noise]", rangemode: "tozero" },
      }),
  };
}

export function adoptionSection({ result, picture }) {
  const { node, add } = section(`Adopted into ${result.robot}`, list(result.reservations ?? []));
  if (Number.isFinite(result.error_as_written) || Number.isFinite(result.held_out_after))
    add(errorsFigure(result), new View({}));
  if (picture?.before !== undefined)
    node.append(
      element("h3", {}, "What changed in the robot file"),
      element(
        "pre",
        { tabindex: "0", class: "changes", "aria-label": "Lines taken out (-) and put in (+)" },
        ...shownChanges(lineChanges(picture.before, picture.after)).map((line) =>
          element("span", { class: { "-": "out", "+": "in" }[line[0]] }, `${line}\n`),
        ),
      ),
    );
  return node;
}
