import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, Vector3, type BufferAttribute, type InstancedMesh } from "three";
import type { Scene } from "../core/protocol";
import { Batches } from "./batches";

test("a floor with a picture reaches as far as one sees, and the picture stays where it is", () => {
  const floor = {
    type: "plane",
    size: [40, 40],
    pose: [1, 2, 0, 1, 0, 0, 0],
    visual: true,
    color: [1, 1, 1, 1],
    texture: "7",
    tile: [0.5, 30],
  };
  const scene = { bodies: [{ kind: "fixed", shapes: [floor] }], meshes: [], heightmaps: [] } as unknown as Scene;
  const batches = new Batches(scene, { asset: () => "", changed: () => {}, slow: false });
  const poses = new Float32Array([0, 0, 0, 1, 0, 0, 0]);
  for (const [x, y] of [
    [0, 0],
    [1033.3, -71.7],
  ] as const) {
    batches.moveTo(poses);
    batches.spreadFloors(poses, [x, y, 0], 300);
    const mesh = batches.root.children[0] as InstancedMesh;
    const matrix = new Matrix4();
    mesh.getMatrixAt(0, matrix);
    const { position, uv } = mesh.geometry.attributes as Record<string, BufferAttribute>;
    const [low, high] = [new Vector3(Infinity, Infinity, 0), new Vector3(-Infinity, -Infinity, 0)];
    for (let i = 0; i < position!.count; i++) {
      const p = new Vector3().fromBufferAttribute(position!, i).applyMatrix4(matrix);
      low.min(p);
      high.max(p);
      // from the point of the floor's frame, but for whole copies
      for (const [k, at] of [(p.x - 1) / 0.5, (p.y - 2) / 30].entries()) {
        const apart = uv!.getComponent(i, k) - at;
        assert.ok(Math.abs(apart - Math.round(apart)) < 1e-3, `corner ${i}: ${apart}`);
      }
    }
    assert.ok(low.x <= x - 300 && low.y <= y - 300 && high.x >= x + 300 && high.y >= y + 300);
    assert.ok(high.x - low.x < 700 && high.y - low.y < 700);
  }
});
