// What the address of a bundle asks for behind its '#': the time that is shown, and from where.
import { kViews, type ViewName } from "../view3d/views";

export interface Wish {
  /** [s] */
  time?: number;
  view?: ViewName;
  /** What was asked for and cannot be, in words. */
  problems: string[];
}

/** Of "#t=4.2&view=front"; other names are somebody else's. */
export function readAddress(hash: string): Wish {
  const wish: Wish = { problems: [] };
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const time = asked.get("t");
  if (time !== null) {
    const value = /^\s*$/.test(time) ? NaN : Number(time);
    if (Number.isFinite(value)) wish.time = value;
    else wish.problems.push(`the address asks for the time '${time}', which is no number of seconds`);
  }
  const view = asked.get("view");
  if (view !== null) {
    const known = kViews.find((name) => name === view);
    if (known) wish.view = known;
    else wish.problems.push(`the address asks for the view '${view}'; there are ${kViews.join(", ")}`);
  }
  return wish;
}
