// Sections of readings: how a table is understood, what it can show before any fit, the geometry that it determines.
import { element, list, table } from "../dom.js";
import { number, stated, statedWithError } from "../units.js";
import { inPrint, occasionInWords } from "../words.js";

export const isReadings = ({ result }) => result.command === "readings" && Array.isArray(result.columns);
export const isCalibration = ({ result }) => result.command === "calibrate" && Array.isArray(result.stages);
export const isCheck = ({ result }) => result.command === "measure check" && Array.isArray(result.checks);

const valuesOf = ({ range, values }) =>
  range ? (range[0] === range[1] ? number(range[0]) : `${number(range[0])} to ${number(range[1])}`) : `${values} values`;
const placeOf = ({ line, column }) => (line ? `line ${line}${column ? `:${column}` : ""}` : "the file");

export function readingsSection({ result }) {
  const rows = result.columns.map((column) => [
    column.column,
    column.meaning === "covariate" ? "not used, kept" : `${column.negative ? "minus " : ""}${column.meaning}`,
    column.unit === "?" ? "not stated" : inPrint(column.unit),
    valuesOf(column),
    column.missing || "",
  ]);
  return element(
    "section",
    {},
    element("h2", {}, `How ${result.readings} is understood`),
    result.mistakes.length
      ? table(
          ["where", "what is wrong", "what would work"],
          result.mistakes.map((mistake) => [placeOf(mistake), mistake.what, mistake.cure]),
          "To repair before anything can be computed",
        )
      : "",
    table(["column", "understood as", "unit", "values", "missing"], rows, `${result.rows} readings, from line ${result.header_line} on`),
    result.notes.length ? list(result.notes) : "",
  );
}

export function checkSection({ result }) {
  const shown = result.checks.filter((check) => check.observable);
  const hidden = result.checks.filter((check) => !check.observable);
  const name = typeof result.campaign === "string" ? result.campaign : result.campaign.name;
  const most = ({ least, largest, unit }) => `${number(least)} to ${number(largest)} ${unit}`;
  return element(
    "section",
    {},
    element("h2", {}, `What the readings of ${name} can show`),
    element("p", { class: "say" }, occasionInWords(result.campaign)),
    result.notes.length ? list(result.notes) : "",
    hidden.length
      ? table(["not observable", "why", "what would show it"], hidden.map((c) => [c.effect, c.sentence, c.cure]), "Not observable")
      : "",
    shown.length ? table(["observable", "why"], shown.map((c) => [c.effect, c.sentence]), "Observable") : "",
    result.joints.length
      ? table(
          ["joint", "what the loads do to it", "postures", "its stiffness"],
          result.joints.map((joint) => [
            joint.joint,
            most(joint),
            joint.postures,
            joint.observable ? "observable" : "cannot be determined",
          ]),
          "Joints",
        )
      : "",
  );
}

/** Models of the geometry with their errors, and every parameter of the one that was taken. */
export function calibrationSection({ result }) {
  const error = (errors, key) => (errors?.[key] === null || errors?.[key] === undefined ? "-" : stated(errors[key], "m"));
  const rows = result.stages.map((stage) => [
    stage.name + (stage.name === result.taken ? " (taken)" : ""),
    stage.parameters,
    error(stage.fitted, "translation_rms"),
    error(stage.held_out, "translation_rms"),
    error(stage.held_out, "translation_max"),
  ]);
  const parameters = result.geometry.map((one) => [
    one.what,
    one.at,
    stated(one.before, one.unit),
    statedWithError(one.value, one.standard_error, one.unit),
    one.significant ? "significant" : "may be zero",
  ]);
  const left = result.left_out.map((one) => [one.what, one.reason, one.like.join(", ")]);
  return element(
    "section",
    {},
    element("h2", {}, "The geometry of the robot"),
    table(["model", "parameters", "rms fitted", "rms held out", "largest held out"], rows, "Error of one coordinate, by model"),
    parameters.length ? table(["parameter", "behind", "before", "calibrated", "significance"], parameters, "Calibrated parameters") : "",
    left.length ? table(["left as it was", "why", "like"], left, "What these poses do not determine") : "",
  );
}
