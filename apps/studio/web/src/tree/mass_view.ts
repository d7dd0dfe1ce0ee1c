// Mass, centre of mass and inertia of some elements' bodies, as text.
import { messageOf } from "../core/link";
import type { Answer } from "../core/protocol";
import type { Studio } from "../core/studio";
import { shortNumber } from "../forms/values";

const list = (values: readonly (number | null)[], digits: number): string =>
  values.map((v) => (v === null ? "none" : shortNumber(Number(v.toPrecision(digits))))).join("  ");

/** Name and value of each line. */
export function massLines(answer: Answer<"mass">): [string, string][] {
  const [xx, yy, zz, xy, xz, yz] = answer.inertia;
  const lines: [string, string][] = [
    ["mass", `${list([answer.mass], 5)} kg`],
    ["centre of mass", `${list(answer.com, 4)} m`],
    ["inertia xx yy zz", `${list([xx ?? 0, yy ?? 0, zz ?? 0], 4)} kg m²`],
  ];
  // Products far below the moments are rounding.
  const largest = Math.max(Math.abs(xx ?? 0), Math.abs(yy ?? 0), Math.abs(zz ?? 0));
  const products = [xy ?? 0, xz ?? 0, yz ?? 0].map((p) => (Math.abs(p) < 1e-9 * largest ? 0 : p));
  if (products.some((p) => p !== 0)) lines.push(["inertia xy xz yz", `${list(products, 4)} kg m²`]);
  return lines;
}

/** A list of the lines, or why there is none. */
export async function massElement(studio: Studio, elements: number[]): Promise<HTMLElement> {
  const root = document.createElement("dl");
  root.className = "cg-mass";
  root.dataset.testid = "mass-preview";
  root.setAttribute("aria-label", "Mass of the whole");
  const add = (name: string, value: string) => {
    const term = document.createElement("dt");
    term.textContent = name;
    const text = document.createElement("dd");
    text.textContent = value;
    root.append(term, text);
  };
  try {
    const answer = await studio.link.request("mass", { elements });
    for (const [name, value] of massLines(answer)) add(name, value);
    add("bodies", answer.bodies.join(", "));
  } catch (error) {
    add("mass", messageOf(error));
  }
  return root;
}
