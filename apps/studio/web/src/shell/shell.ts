// What the parts of the window are given: the studio, and what only the window can do.
import type { Studio } from "../core/studio";
import type { Docking } from "./docking";

export interface Shell extends Studio {
  readonly docking: Docking;
  /** Shows an error to the user; a broken connection has its own bar. */
  fail(error: unknown): void;
  /** Moves a panel into a window of its own. */
  popOut(panel: string): void;
}
