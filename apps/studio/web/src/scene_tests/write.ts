// Tests as text, and what is known of them: plain logic.
import type { Answer, Pose, Scene, SceneTest, TestVerdict } from "../core/protocol";
import { jointUnit } from "../hands/mechanism";
import { escapeAttribute } from "../forms/xml_text";

/** How far off a measured value may be, as first proposed: 1 cm, 1 degree. */
export const kTolerance = { m: 0.01, rad: Math.PI / 180 };

/** What a test can be made of: positions of bodies, coordinates of joints. */
export interface Seen {
  /** a signal */
  that: string;
  value: number;
  unit: "m" | "rad";
}

/** What is seen of the selected elements: the position of each body they made, the coordinate of each joint. */
export function seenOf(
  scene: Scene,
  selected: readonly number[],
  bodies: Iterable<number>,
  poseOf: (body: number) => Pose | null,
  jointPosition: (joint: number) => number | null,
): Seen[] {
  const chosen = new Set(selected);
  const joints = scene.joints.flatMap((joint, i): Seen[] => {
    const value = jointPosition(i);
    if (!chosen.has(joint.element) || joint.removed || value === null) return [];
    if (!["hinge", "slider", "screw"].includes(joint.type)) return [];
    return [{ that: `${joint.name}.position`, value, unit: jointUnit(joint) }];
  });
  if (joints.length > 0) return joints;
  return [...bodies].flatMap((index) => {
    const body = scene.bodies[index];
    const pose = poseOf(index);
    if (!body || !pose || body.kind === "fixed") return [];
    return (["x", "y", "z"] as const).map((axis, i) => ({
      that: `${body.name}.${axis}`,
      value: pose[i]!,
      unit: "m" as const,
    }));
  });
}

const short = (value: number, digits: number): string => String(Number(value.toFixed(digits)));
const quantity = (value: number, unit: "m" | "rad"): string =>
  unit === "m" ? `${short(value, 5)} m` : `${short((value * 180) / Math.PI, 3)} deg`;

/** A `<test>` that says what is seen at `time` [s]; `tolerances` by unit. */
export function testXml(name: string, time: number, seen: readonly Seen[], tolerances: typeof kTolerance): string {
  const lines = seen.map(
    ({ that, value, unit }) =>
      `  <expect that="${escapeAttribute(that)}" equals="${quantity(value, unit)}" tolerance="${quantity(tolerances[unit], unit)}"/>`,
  );
  return [`<test name="${escapeAttribute(name)}" duration="${short(time, 9)} s">`, ...lines, "</test>"].join("\n");
}

/** The runs that a test needs on the chosen engines: one for each, and all together where it compares them. */
export function runsOf(test: SceneTest, chosen: readonly string[]): string[][] {
  const engines = chosen.filter((name) => test.backends.length === 0 || test.backends.includes(name));
  const alone = test.expectations > 0 ? engines.map((name) => [name]) : [];
  return test.agrees > 0 && engines.length > 1 ? [...alone, engines] : alone;
}

export type TestResult = Answer<"test">;

/** When it went wrong: of the first verdict that failed; null: it has no time. */
export function momentOf(result: TestResult): number | null {
  return result.verdicts.find((v) => !v.passed)?.time ?? null;
}

/** What to read of a result, the failures first. */
export function failuresOf(result: TestResult): TestVerdict[] {
  return result.verdicts.filter((v) => !v.passed);
}
