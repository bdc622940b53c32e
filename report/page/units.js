// Numbers as people write them: SI values to natural units, or to those that were chosen for the page.

const steps = {
  length: [[1e-9, "nm"], [1e-6, "µm"], [1e-3, "mm"], [1, "m"]],
  angle: [[1e-6, "µrad"], [1e-3, "mrad"], [1, "rad"]],
  force: [[1e-3, "mN"], [1, "N"], [1e3, "kN"]],
  moment: [[1e-3, "mN m"], [1, "N m"], [1e3, "kN m"]],
  stiffness: [[1, "N/m"], [1e3, "N/mm"], [1e6, "N/µm"]],
  torsion: [[1, "N m/rad"], [1e3, "N m/mrad"], [1e6, "N m/µrad"]],
  compliance: [[1e-9, "nm/N"], [1e-6, "µm/N"], [1e-3, "mm/N"], [1, "m/N"]],
  turning: [[1e-9, "nrad/(N m)"], [1e-6, "µrad/(N m)"], [1e-3, "mrad/(N m)"], [1, "rad/(N m)"]],
  crossing: [[1e-9, "nrad/N"], [1e-6, "µrad/N"], [1e-3, "mrad/N"], [1, "rad/N"]],
  plain: [[1, ""]],
};

const inch = 0.0254;
const pound = 4.4482216152605; // pound-force, by definition
// Steps that a choice has instead. What is large is not written in small units: a robot is no million µm long.
const chosenSteps = {
  mm: {
    length: [[1e-3, "mm"], [10, "m"]],
    stiffness: [[1e3, "N/mm"]],
    compliance: [[1e-3, "mm/N"]],
  },
  "µm": {
    length: [[1e-6, "µm"], [1e-2, "mm", 1e-3], [10, "m", 1]],
    stiffness: [[1e6, "N/µm"]],
    compliance: [[1e-6, "µm/N"]],
  },
  inch: {
    length: [[1e-6 * inch, "µin"], [1e-3 * inch, "in", inch]],
    force: [[pound, "lbf"]],
    moment: [[pound * inch, "lbf in"]],
    stiffness: [[pound / inch, "lbf/in"]],
    torsion: [[pound * inch, "lbf in/rad"]],
    compliance: [[(1e-6 * inch) / pound, "µin/lbf"], [(1e-3 * inch) / pound, "in/lbf", inch / pound]],
    turning: [[1e-6 / (pound * inch), "µrad/(lbf in)"], [1 / (pound * inch), "rad/(lbf in)"]],
    crossing: [[1e-6 / pound, "µrad/lbf"], [1 / pound, "rad/lbf"]],
  },
};
export const unitChoices = [
  ["", "as they read best"],
  ["mm", "mm"],
  ["µm", "µm"],
  ["inch", "inch"],
];

const storedAs = "kinetostat-units";
let chosen = "";
/** Which units were chosen, by this page or an earlier one. */
export function unitChoice() {
  try {
    const kept = localStorage.getItem(storedAs) ?? "";
    if (unitChoices.some(([key]) => key === kept)) chosen = kept;
  } catch {
    // A browser that keeps nothing: as long as the page is open.
  }
  return chosen;
}
export function chooseUnits(choice) {
  chosen = choice;
  try {
    localStorage.setItem(storedAs, choice);
  } catch {
    // As above.
  }
}


/** The unit in which values of a kind that are at most `largest` (SI) read best: {unit, factor}. */
export function unitFor(kind, largest) {
  const list = chosenSteps[chosen]?.[kind] ?? steps[kind];
  let best = list[0];
  for (const step of list) if (largest >= 0.95 * step[0]) best = step;
  const [from, unit, factor = from] = best;
  return { factor, unit };
}

export const isRotation = (component) => component.startsWith("r");
export const kindOf = (component) => (isRotation(component) ? "angle" : "length");

/** "0.0123", "1.2e-7", "-" where there is no number. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (!Number.isFinite(value)) return value > 0 ? "infinite" : "-infinite";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3)
    return value
      .toExponential(digits - 1)
      .replace(/\.?0+e/, "e")
      .replace("e+", "e");
  const text = value.toPrecision(digits);
  const plain = text.includes("e") ? String(Number(text)) : text;
  return plain.includes(".") ? plain.replace(/\.?0+$/, "") : plain;
}

export function quantity(value, kind, digits = 3) {
  const { factor, unit } = unitFor(kind, Math.abs(value));
  return `${number(value / factor, digits)} ${unit}`.trim();
}

const kindOfUnit = {
  m: "length",
  rad: "angle",
  N: "force",
  "N/m": "stiffness",
  "N m^-1": "stiffness",
  "N m/rad": "torsion",
  "N m rad^-1": "torsion",
  "m N^-1": "compliance",
  "N^-1 m": "compliance",
  "N^-1 m^-1 rad": "turning",
};
/** The unit in which a value stated in SI reads best: {unit, factor}. */
export const unitOf = (value, unit) =>
  kindOfUnit[unit] ? unitFor(kindOfUnit[unit], Math.abs(value)) : { factor: 1, unit };

// Units of robot files.
const siOf = {
  "N/m": ["stiffness", 1],
  "N/mm": ["stiffness", 1e3],
  "N/um": ["stiffness", 1e6],
  m: ["length", 1],
  mm: ["length", 1e-3],
  um: ["length", 1e-6],
};
/** Values in a unit of a robot file as they were chosen to be shown: {values, unit}; as they are without a choice. */
export function asChosen(values, unit) {
  const [kind, factor] = siOf[unit] ?? [];
  if (!chosen || !kind) return { values, unit };
  const known = values.flat().filter((v) => v !== null && Number.isFinite(v));
  const best = unitFor(kind, factor * known.reduce((most, v) => Math.max(most, Math.abs(v)), 0));
  const one = (v) => (Array.isArray(v) ? v.map(one) : v === null ? null : (v * factor) / best.factor);
  return { values: values.map(one), unit: best.unit };
}

const ofSentences = {
  ...siOf,
  N: ["force", 1],
  kN: ["force", 1e3],
  "mm/N": ["compliance", 1e-3],
  "um/N": ["compliance", 1e-6],
  "nm/N": ["compliance", 1e-9],
};
const written = "-?\\d+(?:\\.\\d+)?(?:e-?\\d+)?";
// Numbers that one unit closes, "1277 to 3540 N/mm" or "(-60, 0, 0) mm", and those in brackets behind it, "0.16 mm (0, -0.15, 0)".
const measured = new RegExp(
  `(\\(${written}(?:, ${written})*\\)|${written} (?:to|\\+-|±) ${written}|(?<![\\w.(])(?<!to |\\+- |± )${written}) ([mkuµn]?[mN](?:/(?:[uµm]?m|N))?)(?![\\w/^(]| m\\b)((?: (?:\\+-|±) [\\d.]+ %)?)( \\(${written}(?:, ${written})+\\)(?! [mkuµ]?[mN]\\b))?`,
  "g",
);
const digitsOf = (text) => Math.max(1, text.replace(/e.*$/, "").replace(/[^\d]/g, "").replace(/^0+/, "").length);

/** A sentence with its lengths, forces and stiffnesses in the units that were chosen, as sharp as they were; as it is without a choice. */
export function sentenceAsChosen(text) {
  if (!chosen) return text;
  return text.replace(measured, (all, values, unit, spread, behind) => {
    const [kind, si] = ofSentences[unit.replace("µ", "u")] ?? [];
    if (!kind) return all;
    const largest = Math.max(...values.match(new RegExp(written, "g")).map((v) => Math.abs(Number(v))));
    const best = unitFor(kind, largest * si);
    const others = (part) =>
      part.replace(new RegExp(written, "g"), (v) => number((Number(v) * si) / best.factor, digitsOf(v)));
    return `${others(values)} ${best.unit}${spread}${behind ? others(behind) : ""}`;
  });
}

/** "27.6 mm", for a unit as a result states it ("m", "N m/rad", ...). */
export function stated(value, unit, digits = 3) {
  const best = unitOf(value, unit);
  return `${number(value / best.factor, digits)} ${best.unit}`.trim();
}
/** "13.3 ± 0.32 µm". */
export function statedWithError(value, error, unit) {
  const best = unitOf(Math.max(Math.abs(value), error), unit);
  return `${number(value / best.factor)} ± ${number(error / best.factor, 2)} ${best.unit}`.trim();
}

export const probability = (p) => (p < 1e-300 ? "p < 1e-300" : `p = ${number(p, 2)}`);
