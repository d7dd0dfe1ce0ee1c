// The help of an attribute in its form.
import type { AttributeSchema } from "./schema";
import { shortNumber } from "./values";

/** "≥ 0 m, ≤ 5 m" of what may be entered. */
function rangeText(spec: AttributeSchema): string {
  const unit = spec.units.length === 1 && spec.units[0] !== "" && spec.units[0] !== "1" ? ` ${spec.units[0]}` : "";
  const parts: string[] = [];
  if (spec.min !== null) parts.push(`${spec.aboveMin ? ">" : "≥"} ${shortNumber(spec.min)}${unit}`);
  if (spec.max !== null) parts.push(`≤ ${shortNumber(spec.max)}${unit}`);
  if (spec.noneAllowed) parts.push("or none");
  return parts.join(", ");
}

export function helpText(spec: AttributeSchema): string {
  const parts = [spec.doc];
  const range = rangeText(spec);
  if (range !== "") parts.push(`(${range})`);
  if (spec.default !== "") parts.push(`Default: ${spec.default}.`);
  return parts.filter((p) => p !== "").join(" ");
}
