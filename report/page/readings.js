// Readings in columns, and the questions of charts to them. SI throughout.
import { groups, largest, rms } from "./numbers.js";
import { modelInWords } from "./words.js";

export class Readings {
  constructor(columns) {
    Object.assign(this, columns);
    this.models = this.models.map((model) => ({ ...model, name: modelInWords(model.name) }));
    this.count = this.id.length;
    this.usedBy = new Map();
    this.components = Object.keys(this.measured);
    this.loads = Object.keys(this.load);
    this.largestLoad = Object.fromEntries(
      this.loads.map((name) => [name, largest(this.load[name])]),
    );
    this.branch = this.branches();
  }

  /** Indices of readings in use whose component was measured. */
  used(component) {
    if (!this.usedBy.has(component)) {
      const values = this.measured[component];
      const predicted = this.models[0].residual[component];
      const known = (i) => !this.masked[i] && values[i] !== null && predicted[i] !== null;
      this.usedBy.set(component, [...values.keys()].filter(known));
    }
    return this.usedBy.get(component);
  }
  heldOut(i) {
    return this.role[i] !== 0;
  }
  hasHeldOut() {
    return this.role.some((role, i) => role !== 0 && !this.masked[i]);
  }
  sigmaAt(component, i) {
    return this.sigma ? this.sigma[component][i] : null;
  }
  /** rms of the noise of one component; null when nobody knows it. */
  noiseOf(component) {
    if (!this.sigma) return null;
    const used = this.used(component);
    return used.length ? rms(used.map((i) => this.sigma[component][i])) : null;
  }
  residual(model, component, i) {
    return this.models[model].residual[component][i];
  }
  /** In units of the noise, what readings share taken out where the result has it so; [m or rad] where it is not known. */
  whitened(model, component, i) {
    const known = this.sigma && this.models[model].whitened?.[component];
    if (known) return known[i];
    const value = this.residual(model, component, i);
    return this.sigma ? value / this.sigma[component][i] : value;
  }

  /** Where most of the load is: "fx" with its sign, "+fx"; "none" without load. Moments count over the largest. */
  direction(i) {
    let best = null;
    let size = 1e-9;
    for (const name of this.loads) {
      const share = Math.abs(this.load[name][i]) / (this.largestLoad[name] || 1);
      if (share > size) [best, size] = [name, share];
    }
    return best === null ? "none" : `${this.load[best][i] > 0 ? "+" : "-"}${best}`;
  }

  /** 1 loading, 2 unloading, 0 unstated: as the file says, else by the order within the cycle. */
  branches() {
    if (this.stated?.some((value) => value !== 0)) return this.stated;
    const size = (i) =>
      Math.hypot(...this.loads.map((name) => this.load[name][i] / (this.largestLoad[name] || 1)));
    const result = new Array(this.count).fill(0);
    for (const members of groups([...this.cycle.keys()], (i) => this.cycle[i]).values()) {
      if (members.length < 3 || members.length > 200) continue;
      for (let k = 1; k < members.length; ++k) {
        const change = size(members[k]) - size(members[k - 1]);
        result[members[k]] = change > 1e-9 ? 1 : change < -1e-9 ? 2 : 0;
      }
    }
    return result;
  }
  poseText(pose) {
    return this.poses[pose].label || "the only posture";
  }
  /** The same for an axis of a chart. */
  poseName(pose) {
    const text = this.poseText(pose);
    return text.length > 24 ? `posture ${pose + 1}` : text;
  }
  text(i) {
    const loads = this.loads
      .filter((name) => this.load[name][i])
      .map((name) => `${name} ${this.load[name][i]}`)
      .join(", ");
    return `reading ${this.id[i]}, pose ${this.poseText(this.pose[i])}, ${loads || "no load"}`;
  }
}

/** Columns of those components of the load that some reading has. */
function loadsOf(rows) {
  const columns = ["fx", "fy", "fz", "mx", "my", "mz"].map((name, k) => [
    name,
    rows.map((row) => (k < 3 ? row.load?.force[k] : row.load?.moment[k - 3]) ?? 0),
  ]);
  return Object.fromEntries(columns.filter(([, values]) => values.some((v) => v !== 0)));
}

/** From what `--json` wrote. `poses`: its configurations; files of old have none, and no loads. */
export function columnsFromResult(comparison, poses = comparison.configurations) {
  const rows = comparison.readings;
  const component = (key) => {
    const measured = comparison.components.filter((_, k) =>
      rows.some((row) => row.measured[k] !== null),
    );
    return Object.fromEntries(
      measured.map((name) => [
        name,
        rows.map((row) => row[key]?.[comparison.components.indexOf(name)] ?? null),
      ]),
    );
  };
  const sessions = [...new Set(rows.map((row) => row.session))];
  const cycles = [...new Set(rows.map((row) => `${row.session}/${row.cycle ?? ""}`))];
  const last = Math.max(0, ...rows.map((row) => row.configuration ?? 0));
  const nameless = Array.from({ length: last + 1 }, (_, k) => ({
    label: last ? `posture ${k + 1}` : "",
    position: [0, 0, 0],
  }));
  const models = [{ name: "nominal", residual: component("residual"), whitened: component("whitened") }];
  if (comparison.refitted)
    models.push({
      name: "fitted",
      residual: component("refitted_residual"),
      whitened: component("refitted_whitened"),
    });
  return {
    file: comparison.campaign?.readings?.file,
    line: rows.map((row) => row.line ?? null),
    noise: comparison.noise,
    sessions,
    models,
    measured: component("measured"),
    sigma: rows.some((row) => row.sigma) ? component("sigma") : undefined,
    load: loadsOf(rows),
    id: rows.map((row) => row.id),
    session: rows.map((row) => sessions.indexOf(row.session)),
    masked: rows.map((row) => (row.masked ? 1 : 0)),
    role: rows.map((row) => ["fit", "select", "confirm"].indexOf(row.role)),
    pose: rows.map((row) => row.configuration ?? 0),
    stated: rows.map((row) => 1 + ["loading", "unloading"].indexOf(row.direction)),
    cycle: rows.map((row) => cycles.indexOf(`${row.session}/${row.cycle ?? ""}`)),
    cycles,
    poses: poses ?? nameless,
  };
}
