// Terms of the glossary: where a section uses one first, a link to its line at the end of the page.
import { element } from "./dom.js";

// What a text says for a term, where the glossary's own name for it is not what is written.
const otherwise = {
  "nominal, fitted, final model": ["nominal", "fitted"],
  "training, validation, test readings": ["kept out of the fit", "held out"],
  "datum, zero offset": ["datum", "zero offset"],
  "6x6 compliance": ["compliance"],
  "rigid and distributing coupling": ["distributing"],
  "critical load": ["critical point", "critical load", "critical force"],
  "lack of fit": ["lack of fit", "lack-of-fit"],
  "clamping assumption": ["clamping assumption", "clamping"],
  backlash: ["backlash", "clearance"],
  observable: ["observable", "not observable"],
};

/** How a term is written, longest first. */
export const spellings = (term) =>
  (otherwise[term] ?? [term]).sort((a, b) => b.length - a.length);

/** Where the first of these terms stands in a text: {at, length, row}; nothing where none does. */
export function firstTerm(text, rows) {
  let found = null;
  for (const row of rows)
    for (const word of spellings(row.term)) {
      const literal = word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
      const match = new RegExp(`(?<![\\w-])${literal}(?:e?s)?(?![\\w-])`, "i").exec(text);
      if (match && (!found || match.index < found.at))
        found = { at: match.index, length: match[0].length, row };
    }
  return found;
}

const idOf = ({ term }) => `term-${term.replace(/[^a-z0-9]+/gi, "-")}`;
const noPlaceForLinks =
  "a, button, summary, select, label, code, pre, script, svg, h1, h2, h3, .plot, .save, .source, .stations";

/**
 * Links each term once in each section: a reader who came by a link, or from another section, finds it there, too, and no
 * text is all links. A list of the terms; nothing where the page uses none.
 */
export function linkTerms(root, rows) {
  const leftIn = new Map();
  const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
  const used = [];
  for (let node = walker.nextNode(); node; ) {
    const next = () => walker.nextNode();
    const part = node.parentElement.closest("section, details.rest");
    const left = leftIn.get(part) ?? leftIn.set(part, [...rows]).get(part);
    const found = node.parentElement.closest(noPlaceForLinks) ? null : firstTerm(node.data, left);
    if (!found) {
      node = next();
      continue;
    }
    const word = node.splitText(found.at);
    const rest = word.splitText(found.length);
    const link = element("a", { class: "term", href: `#${idOf(found.row)}`, title: found.row.meaning });
    word.replaceWith(link);
    link.append(word);
    used.push(found.row);
    left.splice(left.indexOf(found.row), 1);
    walker.currentNode = rest;
    node = rest;
  }
  if (!used.length) return null;
  return element(
    "details",
    { class: "terms" },
    element("summary", {}, "Terms on this page"),
    element(
      "dl",
      {},
      ...rows
        .filter((row) => used.includes(row))
        .flatMap((row) => [
          element("dt", { id: idOf(row) }, row.term),
          element("dd", {}, `${row.meaning}. `, element("span", { class: "say" }, row.source)),
        ]),
    ),
  );
}

/** The glossary as bundle.mjs put it into the page. */
export const glossaryOfPage = () =>
  JSON.parse(document.getElementById("glossary")?.textContent ?? "[]");
