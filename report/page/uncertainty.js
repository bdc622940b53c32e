// How certain a result is, and what is to blame.
import { element, table } from "./dom.js";
import { number } from "./units.js";

const percent = (share, digits) => `${number(100 * share, digits)} %`;

// What of a result is known to what: [name, number, budget].
const known = ({ uncertainty: u }) =>
  [
    ["the stiffness along the softest direction", u.compliance_along, u.budget],
    ["the displacement", u.moved, u.moved?.budget],
    ["the holding force", u.force, u.force?.budget],
    [`the ${u.of} at the ${u.at}`, u[u.of], u.budget],
  ].find(([, value, budget]) => value && budget) ?? [];

/** A sentence and the budget, for a result of which something is uncertain; else null. */
export function budgetOf(result) {
  if (!result.uncertainty) return null;
  const [name, value, budget] = known(result);
  if (!name || !(value.expanded_uncertainty > 0)) return null;
  const spread = percent(value.expanded_uncertainty / Math.abs(value.estimate), 2);
  const draws = result.uncertainty.draws;
  return element(
    "div",
    {},
    element(
      "p",
      {},
      `Known to \u00b1 ${spread} (k = 2): ${name}${draws ? `, with ${draws.count} draws beside` : ""}.`,
    ),
    table(
      ["source", "share of what is not known"],
      budget.filter((s) => Math.abs(s.share) >= 0.0005).map((s) => [s.source, percent(s.share, 3)]),
      `What ${name} is uncertain by`,
    ),
  );
}
