// A folder of its own for a test of pages, and the program run in it.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

/** The source tree. */
const root = join(dirname(fileURLToPath(import.meta.url)), "../..");

/** The robot file of one drive that slides. */
export const slide = [
  "kinetostat: 1",
  "name: slide",
  "units: {length: mm, force: N, angle: deg}",
  "chain_types:",
  "  arm:",
  "    - actuator: {name: drive, axis: Tz, stiffness: 1000}",
  "manipulator: {chain: arm}",
  "uncertain:",
  "  - {stiffness: drive}",
];

export class Workshop {
  constructor(program) {
    this.program = program;
    this.folder = mkdtempSync(join(tmpdir(), "kinetostat-pages-"));
  }
  /** A file or folder of the tree, under its own name. */
  link(name) {
    symlinkSync(join(root, name), this.path(name));
  }
  path(name) {
    return join(this.folder, name);
  }
  address(name) {
    return `file://${this.path(name)}`;
  }
  write(name, lines) {
    writeFileSync(this.path(name), `${lines.join("\n")}\n`);
  }
  /** What the program prints; throws with what it complains of. */
  run(...words) {
    return execFileSync(this.program, words, {
      cwd: this.folder,
      env: { ...process.env, XDG_CACHE_HOME: this.path("cache") },
      encoding: "utf8",
      stdio: ["ignore", "pipe", "pipe"],
    });
  }
  remove() {
    rmSync(this.folder, { recursive: true });
  }
}
