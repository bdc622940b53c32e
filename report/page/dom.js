// Elements by name. Text is always text, never markup: names come from users' files.

export function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

export function list(sentences, attributes = {}) {
  return element("ul", attributes, ...sentences.map((sentence) => element("li", {}, sentence)));
}

export function table(columns, rows, caption) {
  // Not what goes on in words, or is several numbers.
  const isNumber = (value) =>
    typeof value === "number" || (/^[-+]?[\d.]/.test(value) && !/, | along |% \S|[a-z]{4,} [a-z]/.test(value));
  // A sentence would become a column of words on a narrow screen.
  const kind = (value) => (isNumber(value) ? "number" : String(value).length > 40 ? "sentence" : undefined);
  const cell = (value) => element("td", { class: kind(value) }, String(value));
  const heading = (name, k) =>
    element(
      "th",
      { scope: "col", class: k > 0 && rows.some((row) => isNumber(row[k])) ? "number" : undefined },
      name,
    );
  return element(
    "div",
    { class: "scroll", tabindex: "0", role: "group", "aria-label": caption },
    element(
      "table",
      {},
      element("caption", {}, caption),
      element("thead", {}, element("tr", {}, ...columns.map(heading))),
      element(
        "tbody",
        {},
        ...rows.map((row) =>
          element(
            "tr",
            {},
            element("th", { scope: "row" }, String(row[0])),
            ...row.slice(1).map(cell),
          ),
        ),
      ),
    ),
  );
}

/** A labelled choice. `options`: [value, text]. */
export function choice(label, options, value, change) {
  const select = element(
    "select",
    { onchange: (event) => change(event.target.value) },
    ...options.map(([key, text]) =>
      element("option", { value: key, selected: String(key) === String(value) }, text),
    ),
  );
  return element("label", {}, `${label} `, select);
}

export function slider(label, { from, to, step, value, show }, change) {
  const shown = element("output", {}, show(value));
  const input = element("input", {
    type: "range",
    min: from,
    max: to,
    step,
    value,
    "aria-label": label,
    oninput: (event) => {
      shown.textContent = show(Number(event.target.value));
      change(Number(event.target.value));
    },
  });
  return element("label", {}, `${label} `, input, " ", shown);
}

/** Text for Plotly, which would take <b> and &amp; for markup. */
export const plain = (text) =>
  String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");

export function download(name, type, content) {
  const link = element("a", {
    download: name,
    href: URL.createObjectURL(new Blob([content], { type })),
  });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** To the clipboard, also where the browser keeps it from pages that are opened as files. Resolves to whether it is there. */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = element("textarea", { readonly: true });
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

/** The same for a drawing. */
export const svgElement = (name, attributes = {}, ...children) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes))
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== false) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
