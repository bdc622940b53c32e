// The page of a study: six stations, the physical picture beside the bent robot, the error that falls, what to read next.
import { againstLoad, extraDeflection, jointCurve } from "./against_load.js";
import { element, table } from "./dom.js";
import { Figure } from "./figure.js";
import { worstComponent } from "./measurements.js";
import { sharesFigure, skeletonFigure } from "./postures.js";
import { workTable } from "./plans.js";
import { Readings } from "./readings.js";
import { budgetOf } from "./uncertainty.js";
import { number } from "./units.js";
import { View } from "./view.js";
import { stagesOfDiagnosis, waterfall } from "./waterfall.js";
import { inPrint, occasionInWords } from "./words.js";

export const isStudy = ({ result }) =>
  result.command === "study" && Array.isArray(result.stations);

const places = {
  readings: "study-readings",
  model: "study-error",
  fitted: "study-error",
  missing: "study-missing",
  adopted: "study-files",
  next: "study-next",
  links: "study-links",
};

/** Names of one of several studies on a page are its own. */
const idIn = (which, id) => (which ? `${id}-${which}` : id);

function stations(list, which) {
  return element(
    "nav",
    { class: "stations", "aria-label": which ? `Stations of study ${which}` : "Stations of this study" },
    ...list.map((station, k) =>
      element(
        "a",
        { href: `#${idIn(which, places[station.name] ?? "study-rest")}`, class: station.light },
        element("b", {}, `${k + 1} ${station.name}`),
        element("span", {}, inPrint(station.sentence)),
      ),
    ),
  );
}

/** What is missing, in pictures: at a joint its curve, elsewhere the error against the load. */
function physicalPictures({ result, picture }, source) {
  if (picture?.joint_curve)
    return [jointCurve, extraDeflection].map(
      (spec) => new Figure(spec(picture.joint_curve, source)).node,
    );
  if (!picture?.readings) return [];
  const readings = new Readings(picture.readings);
  if (!readings.loads.length) return [];
  const view = new View({
    model: Math.max(0, readings.models.findLastIndex((m) => m.name !== "with the effect")),
    component: worstComponent(readings),
    pose: null,
  });
  return [new Figure(againstLoad(readings, view, source), view).node];
}

const titleOf = ({ load, skeletons }) => {
  if (skeletons.length < 2) return "The robot";
  return !load || load.force.some((f) => f !== 0) ? "The robot under load" : "The robot under its own weight";
};

function bentRobot({ result, picture }, source) {
  if (!picture?.robot) return null;
  const view = new View({});
  const spec = skeletonFigure({ command: "study" }, picture.robot.skeletons, view, source, {
    load: picture.robot.load,
    joint: picture.joint_curve?.joint ?? picture.robot.joint,
  });
  return new Figure({ ...spec, title: titleOf(picture.robot), wide: false, height: 420 }, view).node;
}

/** The joint's curve, the robot beside it, then the rest. */
const besideRobot = ([first, ...others], robot) => [first ?? null, robot, ...others];

function excludedTable(excluded) {
  if (!excluded?.length) return null;
  return table(
    ["not it", "odds"],
    excluded.map((row) => [row.effect, row.odds]),
    "Candidates that were weighed and are not it",
  );
}

const restOf = (rest, which) =>
  rest.length
    ? element(
        "details",
        { class: "rest", id: idIn(which, "study-rest") },
        element("summary", {}, "Every chart, test and table of all steps"),
        ...rest,
      )
    : null;

/** The robot with its links by several models; the last is what the others are compared to. */
function linkTable(models, which) {
  if (!models) return null;
  const percent = (share) => `${share < 0 ? "" : "+"}${number(100 * share, 3)} %`;
  const last = models.rows.at(-1);
  const others = (row, text) => (row === last ? "" : text(row));
  const links = Object.keys(models.rows[0].by_link);
  const node = table(
    [
      "links",
      `${models.figure} [${models.unit}]`,
      `against ${last.model}`,
      ...links.map((link) => `${link} alone`),
    ],
    models.rows.map((row) => [
      row.model,
      number(row.value / models.factor, 4),
      others(row, () => percent(row.difference)),
      ...links.map((link) => others(row, () => percent(row.by_link[link]))),
    ]),
    "The robot with its links as beams and by finite elements",
  );
  node.id = idIn(which, "study-links");
  return node;
}

/** Of a robot without readings. */
function designSection(entry, rest, which) {
  const { result } = entry;
  const robot = bentRobot(entry, `Source: ${result.inputs.robot.file}.`);
  return element(
    "section",
    { class: "study", id: idIn(which, "study-next") },
    which ? element("h2", {}, inPrint(result.headline)) : element("h2", {}, result.design),
    stations(result.stations, which),
    element(
      "div",
      { class: "charts" },
      ...(robot ? [robot] : []),
      element(
        "div",
        {},
        new Figure(sharesFigure(result, `Source: ${result.inputs.robot.file}.`)).node,
        budgetOf(result) ?? "",
        linkTable(result.link_models, which) ?? "",
      ),
    ),
    restOf(rest, which) ?? "",
  );
}

/** `rest`: the sections of all steps. `which`: which of several on the page, from 1; 0 where it is alone. */
export function studySection(entry, rest, which = 0) {
  const { result } = entry;
  const heading = (id, words) => element(which ? "h3" : "h2", { id: idIn(which, id) }, words);
  if (result.design) return designSection(entry, rest, which);
  const source = `Source: ${result.campaign_name}.`;
  const charts = (...nodes) =>
    element("div", { class: "charts" }, ...nodes.filter((node) => node !== null));
  const errors = result.waterfall?.length
    ? new Figure(waterfall(stagesOfDiagnosis(result), source, result.waterfall.length)).node
    : null;
  const beside = element(
    "div",
    {},
    excludedTable(result.excluded) ?? "",
    result.not_observable?.length
      ? element(
          "p",
          {},
          element("strong", {}, "Not observable in these readings: "),
          `${result.not_observable.join(", ")}. 'kinetostat plan --show NAMES' says which readings would show them.`,
        )
      : "",
  );
  const found = ["identified", "narrowed down"].includes(result.verdict);
  return element(
    "section",
    { class: "study" },
    which ? element("h2", {}, inPrint(result.headline)) : "",
    element(
      "p",
      { class: "say", id: idIn(which, "study-readings") },
      `${result.campaign_name}: ${result.about}. ${occasionInWords(result.campaign)}`,
    ),
    stations(result.stations, which),
    heading("study-missing", found ? "What is missing" : "Readings and model"),
    charts(...besideRobot(physicalPictures(entry, source), bentRobot(entry, source))),
    heading("study-error", "The error"),
    element("p", {}, inPrint(result.compared)),
    charts(errors, beside),
    heading("study-next", "What to read next"),
    element("p", {}, inPrint(result.planned)),
    workTable(result.work_list) ?? "",
    heading("study-files", "Files"),
    element("p", {}, inPrint(result.adopted)),
    table(
      ["file", "what it is"],
      result.files.map((f) => [f.file, f.what]),
      "Files beside this page",
    ),
    restOf(rest, which) ?? "",
  );
}
