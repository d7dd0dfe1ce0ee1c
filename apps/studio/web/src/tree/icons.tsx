// One small picture per kind of element, drawn with lines in the colour of the text around.
import type { JSX } from "preact";

const kPaths: Record<string, string> = {
  scene: "M2 12 8 15 14 12M2 8 8 11 14 8M8 1 14 4 8 7 2 4Z",
  box: "M8 1.5 14 5v6l-6 3.5L2 11V5ZM2 5l6 3.5L14 5M8 8.5v6",
  sphere: "M14 8A6 6 0 1 1 2 8a6 6 0 0 1 12 0ZM2 8c2 2.6 10 2.6 12 0",
  cylinder: "M3 4c0-2.7 10-2.7 10 0v8c0 2.7-10 2.7-10 0ZM3 4c0 2.7 10 2.7 10 0",
  capsule: "M4 5.5a4 4 0 0 1 8 0v5a4 4 0 0 1-8 0ZM4 5.5c0 2 8 2 8 0",
  ellipsoid: "M15 8A7 4.500 0 1 1 1 8a7 4.500 0 0 1 14 0ZM1 8c2 2 12 2 14 0",
  wheels: "M4 6h8v4H4ZM1.500 4h2.500v8H1.500ZM12 4h2.500v8H12Z",
  cone: "M8 1.500 13 12c0 2.700-10 2.700-10 0Z",
  prism: "M2 11 6 8.500 14 11 6 14ZM2 4 6 1.500 14 4 6 7ZM2 4v7M6 7v7M14 4v7",
  plane: "M1 11 5 5h10l-4 6Z",
  mesh: "M8 2 14 13H2ZM5 7.5h6L8 13Z",
  heightmap: "M1 13l4-7 3 4 2-3 5 6Z",
  body: "M2 6h7v7H2ZM7 6V3h7v7H9",
  assembly: "M2 2h5v5H2ZM9 9h5v5H9ZM7 4.5h4.5V9",
  frame: "M4 12V2M4 12h10M4 12 1.5 14.5",
  joint: "M1 13l4.5-4.5M10.5 7.5 15 3M11 8a3 3 0 1 1-6 0 3 3 0 0 1 6 0Z",
  slider: "M2 11h12M5 11V7h6v4M2 4h12M4 2 2 4l2 2M12 2l2 2-2 2",
  motor: "M2 5h9v6H2ZM11 8h4M4 5V3h5v2M4 11v2h5v-2",
  couple: "M7 8A3 3 0 1 1 1 8a3 3 0 0 1 6 0ZM15 8a4 4 0 1 1-8 0 4 4 0 0 1 8 0ZM4 8h.1M11 8h.1",
  force: "M2 14 13 3M8 3h5v5",
  spring: "M1 8h2l1-4 2 8 2-8 2 8 2-8 1 4h2",
  buoyancy: "M1 10c2-2 3-2 5 0s3 2 5 0 3-2 4 0M1 14c2-2 3-2 5 0s3 2 5 0 3-2 4 0M8 8V1.500M5.500 4 8 1.500 10.500 4",
  wind: "M1 6h8a2 2 0 1 0-2-2M1 9h11a2 2 0 1 1-2 2M1 12h5a1.500 1.500 0 1 1-1.500 1.500",
  randomize: "M2 2h12v12H2ZM5.500 5.500h.1M10.500 5.500h.1M8 8h.1M5.500 10.500h.1M10.500 10.500h.1",
  camera: "M1 5h3l1.5-2h5L12 5h3v8H1ZM10.5 9a2.5 2.5 0 1 1-5 0 2.5 2.5 0 0 1 5 0Z",
  sensor: "M3 13V9M6 11a4 4 0 0 0-4-4M9.500 11A7.500 7.500 0 0 0 2 3.500M13 11A11 11 0 0 0 8 2",
  controller: "M4 4h8v8H4ZM6 1v3M10 1v3M6 12v3M10 12v3M1 6h3M1 10h3M12 6h3M12 10h3",
  light: "M5.500 11a4 4 0 1 1 5 0v1.500h-5ZM6.500 15h3",
  view: "M1 8c3.500-6 10.500-6 14 0-3.500 6-10.500 6-14 0ZM10 8a2 2 0 1 1-4 0 2 2 0 0 1 4 0Z",
  material:
    "M8 2c7 0 7 8 3 7.500-2-.3-2 1-1.300 2.500C10.500 14 3 15 2 8.500 1.500 4.500 5 2 8 2ZM5 7h.1M8 5h.1M11 6h.1",
  physics: "M8 7.900h.1M14.500 8c0 4-13 4-13 0s13-4 13 0ZM8 1.500c4 0 4 13 0 13s-4-13 0-13Z",
  reuse: "M2 2h8v8H2ZM6 12v2h8V6h-2",
  flow: "M3 8a5 5 0 0 1 9-3M13 8a5 5 0 0 1-9 3M12 1.500V5H8.500M4 14.500V11h3.500",
  event: "M9 1 3 9h4l-1 6 7-8.500H8.500Z",
  region: "M2 5V2h3M11 2h3v3M14 11v3h-3M5 14H2v-3",
  maze: "M2 2h12v12H5M2 14V5h9v6H8V8",
  plot: "M2 2v12h12M4 11l3-4 3 2 4-6",
  test: "M2 8.500 6 12.500 14 3.500",
  signal: "M1 8h2.500L5.500 3l4 10 2-5H15",
  other: "M6 3 1 8l5 5M10 3l5 5-5 5",
};

const kKinds: Record<string, string> = {
  hinge: "joint",
  ball: "joint",
  universal: "joint",
  gimbal: "joint",
  fixed: "joint",
  cylindrical: "joint",
  planar: "slider",
  screw: "joint",
  free: "joint",
  servo: "motor",
  drag: "wind",
  encoder: "sensor",
  pose: "sensor",
  imu: "sensor",
  infrared: "sensor",
  lidar: "sensor",
  "force-torque": "sensor",
  contact: "sensor",
  supervisor: "controller",
  set: "controller",
  param: "reuse",
  import: "reuse",
  prototype: "reuse",
  instance: "reuse",
  template: "reuse",
  export: "reuse",
  repeat: "flow",
  for: "flow",
  if: "flow",
  on: "event",
  door: "maze",
  scatter: "maze",
  record: "plot",
  measure: "test",
  collide: "material",
};

export function Icon({ tag }: { tag: string }): JSX.Element {
  const path = kPaths[tag] ?? kPaths[kKinds[tag] ?? "other"] ?? kPaths.other!;
  return (
    <svg class="cg-icon" viewBox="0 0 16 16" width="16" height="16" aria-hidden="true" focusable="false">
      <path
        d={path}
        fill="none"
        stroke="currentColor"
        stroke-width="1.2"
        stroke-linejoin="round"
        stroke-linecap="round"
      />
    </svg>
  );
}
