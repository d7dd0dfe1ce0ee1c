// Where the selected body is now and how fast it is.
import { effect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import type { Frame } from "../core/frame";
import { rollPitchYaw } from "../core/pose_signals";
import type { Studio } from "../core/studio";

/** Speed [m/s] of a body between two frames; null: it cannot be computed from them. */
function speedBetween(before: Frame | null, now: Frame, body: number): number | null {
  if (!before || before.scene !== now.scene || before.time === now.time) return null;
  let square = 0;
  for (let i = 0; i < 3; ++i) square += (now.poses[7 * body + i]! - before.poses[7 * body + i]!) ** 2;
  return Math.sqrt(square) / Math.abs(now.time - before.time);
}

// Faster updates could not be read.
const kShortestPause = 100;

const fixed = (values: number[], digits: number): string => values.map((v) => v.toFixed(digits)).join("  ");

export function LiveValues({ studio, body }: { studio: Studio; body: number }): JSX.Element {
  const position = useRef<HTMLElement>(null);
  const turned = useRef<HTMLElement>(null);
  const speed = useRef<HTMLElement>(null);
  useEffect(() => {
    let before: Frame | null = null;
    let shown = -Infinity;
    return effect(() => {
      const frame = studio.state.frame.value;
      const scene = studio.state.scene.peek();
      if (!frame || !scene || frame.scene !== scene.scene || 7 * body + 6 >= frame.poses.length) return;
      if (performance.now() - shown < kShortestPause && studio.state.status.peek()?.state === "playing") return;
      shown = performance.now();
      const pose = Array.from(frame.poses.subarray(7 * body, 7 * body + 7));
      position.current!.textContent = `${fixed(pose.slice(0, 3), 3)} m`;
      const angles = rollPitchYaw(pose[3]!, pose[4]!, pose[5]!, pose[6]!).map((angle) => (angle * 180) / Math.PI);
      turned.current!.textContent = `${fixed(angles, 1)} deg`;
      const fast = speedBetween(before, frame, body);
      speed.current!.textContent = fast === null ? "" : `${fast.toFixed(3)} m/s`;
      before = frame;
    });
  }, [studio, body]);
  return (
    <dl class="cg-mass" data-testid="live-values" aria-label="Now">
      <dt>position</dt>
      <dd ref={position} />
      <dt>roll pitch yaw</dt>
      <dd ref={turned} />
      <dt>speed</dt>
      <dd ref={speed} />
    </dl>
  );
}
