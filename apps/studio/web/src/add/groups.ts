// The menus of what can be inserted: robots first, then what a robot is made of, then the rest.

export const kInsertGroups: { title: string; of: [tag: string, label: string][] }[] = [
  {
    title: "Bodies",
    of: [
      ["box", "Box"],
      ["sphere", "Sphere"],
      ["cylinder", "Cylinder"],
      ["capsule", "Capsule"],
      ["ellipsoid", "Ellipsoid"],
      ["cone", "Cone"],
      ["prism", "Prism"],
      ["mesh", "Mesh"],
      ["wheels", "Wheels and caster"],
      ["body", "Body"],
      ["assembly", "Assembly"],
    ],
  },
  {
    title: "Joints",
    of: [
      ["hinge", "Hinge"],
      ["slider", "Slider"],
      ["ball", "Ball joint"],
      ["universal", "Universal joint"],
      ["gimbal", "Gimbal"],
      ["fixed", "Fixed joint"],
      ["cylindrical", "Cylindrical joint"],
      ["planar", "Planar joint"],
      ["screw", "Screw"],
      ["free", "Free joint"],
      ["couple", "Coupling of joints"],
    ],
  },
  {
    title: "Motors and control",
    of: [
      ["motor", "Motor"],
      ["servo", "Servo"],
      ["controller", "Controller"],
      ["supervisor", "Supervisor"],
    ],
  },
  {
    title: "Sensors",
    of: [
      ["camera", "Camera"],
      ["infrared", "Infrared sensor"],
      ["lidar", "Lidar"],
      ["contact", "Contact sensor"],
      ["imu", "IMU"],
      ["pose", "Pose sensor"],
      ["encoder", "Encoder"],
      ["force-torque", "Force and torque sensor"],
      ["sensor", "Sensor plugin"],
    ],
  },
  {
    title: "Surroundings",
    of: [
      ["plane", "Plane"],
      ["heightmap", "Height field"],
      ["maze", "Maze"],
      ["scatter", "Scattered things"],
      ["light", "Light"],
      ["view", "View"],
      ["material", "Material"],
      ["collide", "Collision rule"],
      ["region", "Region"],
      ["frame", "Frame"],
    ],
  },
  {
    title: "Forces",
    of: [
      ["force", "Force"],
      ["spring", "Spring"],
      ["drag", "Drag"],
      ["buoyancy", "Buoyancy"],
      ["wind", "Wind"],
    ],
  },
  { title: "Experiments", of: [["randomize", "Random values"]] },
];

/** Of commands "robot:…" and "insert:…": the menus and what is in them; in the last what no group names. */
export function insertMenus(ids: readonly string[]): { title: string; ids: string[] }[] {
  const robots = ids.filter((id) => id.startsWith("robot:"));
  const groups = kInsertGroups.map(({ title, of }) => ({
    title,
    ids: of.map(([tag]) => `insert:${tag}`).filter((id) => ids.includes(id)),
  }));
  const named = new Set(groups.flatMap((group) => group.ids));
  const rest = ids.filter((id) => id.startsWith("insert:") && !named.has(id));
  return [{ title: "Robot", ids: robots }, ...groups, { title: "More", ids: rest }].filter((g) => g.ids.length > 0);
}
