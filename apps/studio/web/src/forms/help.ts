// The help of an attribute in its form.
import type { AttributeSchema } from "./schema";
import { short_number } from "./values";

/** "≥ 0 m, ≤ 5 m" of what may be entered. */
export function range_text(spec: AttributeSchema): string {
  const unit = spec.units.length === 1 && spec.units[0] !== "" && spec.units[0] !== "1" ? ` ${spec.units[0]}` : "";
  const parts: string[] = [];
  if (spec.min !== null) parts.push(`${spec.above_min ? ">" : "≥"} ${short_number(spec.min)}${unit}`);
  if (spec.max !== null) parts.push(`≤ ${short_number(spec.max)}${unit}`);
  if (spec.none_allowed) parts.push("or none");
  return parts.join(", ");
}

export function help_text(spec: AttributeSchema): string {
  const parts = [spec.doc];
  const range = range_text(spec);
  if (range !== "") parts.push(`(${range})`);
  if (spec.default !== "") parts.push(`Default: ${spec.default}.`);
  return parts.filter((p) => p !== "").join(" ");
}
