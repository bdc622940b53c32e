// Opens the results of this page and shows the sections that they have something for.
import { beamSection, isBeam } from "./beams.js";
import { adoptionSection, isAdoption } from "./sections/changes.js";
import { calibrationSection, checkSection, isCalibration, isCheck, isReadings, readingsSection } from "./sections/campaign.js";
import { compensationSection, isCompensation } from "./sections/compensation.js";
import { choice, element } from "./dom.js";
import { fleetSection, isFleet } from "./sections/fleet.js";
import { forgetFigures, redrawAll } from "./figure.js";
import { glossaryOfPage, linkTerms } from "./glossary.js";
import { checkedSurfaceSection, isCheckedSurface, isLink, linkSection } from "./links.js";
import { isMap, mapSection } from "./sections/maps.js";
import { campaigns, isMeasurement, measurementSection } from "./measurements.js";
import { isModes, modesSection } from "./sections/modes.js";
import { isPath, pathSection } from "./paths.js";
import { isPlan, planSection } from "./plans.js";
import { isPosture, postureSection } from "./postures.js";
import { startStudio } from "./studio/app.js";
import { isStudy, studySection } from "./study.js";
import { chooseUnits, unitChoice, unitChoices } from "./units.js";
import { inPrint } from "./words.js";

const kinds = [
  [isLink, linkSection],
  [isCheckedSurface, checkedSurfaceSection],
  [isBeam, beamSection],
  [isPosture, postureSection],
  [isPath, pathSection],
  [isMap, mapSection],
  [isCompensation, compensationSection],
  [isPlan, planSection],
  [isModes, modesSection],
  [isAdoption, adoptionSection],
  [isReadings, readingsSection],
  [isCheck, checkSection],
  [isCalibration, calibrationSection],
  [isFleet, fleetSection],
];

// One result that is not as expected does not take the others with it.
function guarded(show, entry) {
  try {
    return show(entry);
  } catch (error) {
    console.error(error);
    return element(
      "section",
      {},
      element("p", { role: "alert" }, `A result could not be drawn: ${error.message}`),
    );
  }
}

/** A result that there is no picture of. */
function textSection({ result, text }) {
  return element(
    "section",
    {},
    element("h2", {}, result.command ?? "Result"),
    element("pre", { tabindex: "0" }, text || JSON.stringify(result, null, 1)),
  );
}

/** What a command says first: of a beam its verdict, of old files and of links the first sentence of their text. */
export function headlineOf({ result, text }) {
  const said = result.headline ?? (isBeam({ result }) && result.verdict ? `${result.link}: ${result.verdict}` : null);
  if (said) return inPrint(said);
  const [first] = (text ?? "").split(/\.\n|\n\n/);
  return first.includes(" ") ? inPrint(first.replaceAll("\n", " ").replace(/\.?$/, ".")) : "";
}

/** The section opens with what the command says first, where that is not the heading of the page. */
function led(node, entry, isOnly) {
  const words = isOnly || isStudy(entry) ? "" : headlineOf(entry);
  if (words) node.querySelector("h2")?.after(element("p", { class: "lead" }, words));
  return node;
}

/** What is about campaigns first, then the rest as it came. `isOnly`: its headline is that of the page. */
function sections(given, isOnly) {
  const studies = given.filter(isStudy);
  if (studies.length) {
    // A story consists of its studies.
    const rest = sections(given.filter((entry) => !isStudy(entry) && entry.result.command !== "demo"), false);
    return studies.map((study, k) =>
      guarded((entry) => studySection(entry, k ? [] : rest, studies.length > 1 ? k + 1 : 0), study),
    );
  }
  const shown = (show, entry) => guarded((e) => led(show(e), e, isOnly), entry);
  const others = given
    .filter((entry) => !isMeasurement(entry))
    .flatMap((entry) => {
      const known = kinds.filter(([is]) => is(entry));
      return known.length ? known.map(([, show]) => shown(show, entry)) : [shown(textSection, entry)];
    });
  const diagnosedFirst = (a, b) => Boolean(b.diagnosis) - Boolean(a.diagnosis);
  const measured = campaigns(given)
    .sort(diagnosedFirst)
    .map((one) =>
      guarded(() => led(measurementSection(one), { result: one.diagnosis ?? one.comparison }, isOnly), one),
    );
  return [...measured, ...others];
}

async function inflated(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) =>
    letter.charCodeAt(0),
  );
  return new Response(
    new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")),
  ).text();
}

function runInPage(text) {
  document.head.append(element("script", {}, text));
}

function about({ result }) {
  const options = Object.entries(result.options ?? {})
    .map(([name, value]) => `${name} ${value}`)
    .join(", ");
  const files = [
    result.inputs?.robot,
    ...(result.inputs?.links ?? []),
    result.campaign?.campaign,
    result.campaign?.readings,
  ].filter((f) => f?.sha256);
  return element(
    "li",
    {},
    `${result.tool ?? "kinetostat"} ${result.command ?? ""} (${options})`,
    element("ul", {}, ...files.map((f) => element("li", {}, `${f.file}, sha256 ${f.sha256}`))),
  );
}

function origins(entries) {
  const texts = entries
    .filter((entry) => entry.text)
    .map((entry) =>
      element(
        "details",
        {},
        element("summary", {}, `The report of ${entry.result.command} as text`),
        element("pre", { tabindex: "0" }, entry.text),
      ),
    );
  return element(
    "section",
    {},
    element("h2", {}, "Where this comes from"),
    ...texts,
    element("ul", { class: "source" }, ...entries.filter((e) => e.result.command).map(about)),
  );
}

function buttons(redo) {
  const dark = () =>
    document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
  const turn = () => {
    document.documentElement.dataset.theme = dark() ? "light" : "dark";
    redrawAll();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
  return element(
    "div",
    { class: "page-tools" },
    choice("Units", unitChoices, unitChoice(), (units) => {
      chooseUnits(units);
      redo();
    }),
    element("button", { type: "button", onclick: turn }, "Light or dark"),
    element("button", { type: "button", onclick: () => print() }, "Print"),
  );
}

/** The sections anew, where the reader is: texts and charts have units, which may have been chosen. */
function fill(page, entries, isOnly) {
  const open = [...page.querySelectorAll("details")].map((node) => node.open);
  const at = scrollY;
  forgetFigures(page);
  page.replaceChildren(...sections(entries, isOnly), origins(entries));
  page.append(linkTerms(page, glossaryOfPage()) ?? "");
  [...page.querySelectorAll("details")].forEach((node, k) => {
    if (open[k]) node.open = true;
  });
  scrollTo(0, at);
}

/** What the command, or the only result, says first is the heading, unless the page was given one. */
function takeHeading([entry, ...others], given) {
  const { command, link } = entry?.result ?? {};
  const isOfCommand = given.startsWith(`${command}: `) || command === "demo";
  const isNameless = others.length === 0 && (/^kinetostat\b/.test(given) || given === link);
  const headline = entry && (isOfCommand || isNameless) ? headlineOf(entry) : "";
  // The title of a study is its headline.
  document.querySelector("h1").textContent = headline || (command === "study" ? inPrint(given) : given);
  return Boolean(headline);
}

async function start() {
  const entries = JSON.parse(await inflated("results"));
  const page = document.getElementById("page");
  const isStudio = entries[0]?.result.command === "studio";
  unitChoice();
  let isOnly = false;
  const given = document.querySelector("h1").textContent;
  const redo = () => {
    if (isStudio) return location.reload();
    takeHeading(entries, given);
    fill(page, entries, isOnly);
  };
  document.getElementById("top").append(buttons(redo));
  if (isStudio) {
    document.body.classList.add("studio");
    let charts = null;
    await startStudio(page, () => (charts ??= inflated("plotly").then(runInPage)));
    page.dataset.ready = "yes";
    return;
  }
  await inflated("plotly").then(runInPage);
  isOnly = takeHeading(entries, given);
  fill(page, entries, isOnly);
  page.dataset.ready = "yes";
}

start().catch((error) => {
  document
    .getElementById("page")
    .replaceChildren(
      element(
        "p",
        { role: "alert" },
        `This page could not be drawn: ${error.message}. It needs a browser of 2023 or later.`,
      ),
    );
  throw error;
});
