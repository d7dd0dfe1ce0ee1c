// Raw programs of Jolt, written as its manual would, and the backend jolt run the same scenes: a box slides over
// a plane at 45 degrees to its axes and a ball falls beside it; two links swing on hinges. Their positions after a
// second are equal bit for bit.
//   node jolt.mjs COGRSIM ADAPTERS SCRATCH
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { adapters, beside } from './beside.mjs';

const engine = 'jolt/node_modules/jolt-physics/dist/jolt-physics.wasm-compat.js';
const { default: load } = await import(pathToFileURL(join(adapters, engine)));
const J = await load();

function makeWorld() {
  const settings = new J.JoltSettings();
  const pairs = new J.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(0, 1);
  pairs.EnableCollision(1, 1);
  const layers = new J.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [0, 1]) layers.MapObjectToBroadPhaseLayer(layer, new J.BroadPhaseLayer(layer));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  const jolt = new J.JoltInterface(settings);
  jolt.GetPhysicsSystem().SetGravity(new J.Vec3(0, 0, -9.81));
  return jolt;
}

const upright = new J.Quat(0, 0, 0, 1);
/** 1 kg with a moment about every axis; without: it stands. */
function body(jolt, shape, [x, y, z], velocity, moment) {
  const dynamic = moment !== undefined;
  const type = dynamic ? J.EMotionType_Dynamic : J.EMotionType_Static;
  const made = new J.BodyCreationSettings(shape, new J.RVec3(x, y, z), upright, type, dynamic ? 1 : 0);
  made.mAllowSleeping = false;
  made.mFriction = 0.5;
  if (dynamic) {
    made.mOverrideMassProperties = J.EOverrideMassProperties_MassAndInertiaProvided;
    made.mMassPropertiesOverride.mMass = 1;
    const inertia = J.Mat44.prototype.sIdentity();
    [[moment, 0, 0], [0, moment, 0], [0, 0, moment]].forEach((c, i) => inertia.SetColumn3(i, new J.Vec3(...c)));
    made.mMassPropertiesOverride.mInertia = inertia;
    made.mLinearVelocity = new J.Vec3(...velocity);
  }
  const bodies = jolt.GetPhysicsSystem().GetBodyInterface();
  const it = bodies.CreateBody(made);
  bodies.AddBody(it.GetID(), dynamic ? J.EActivation_Activate : J.EActivation_DontActivate);
  return it;
}

function hinge(jolt, parent, child, [x, y, z]) {
  const made = new J.HingeConstraintSettings();
  made.mPoint1 = made.mPoint2 = new J.RVec3(x, y, z);
  made.mHingeAxis1 = made.mHingeAxis2 = new J.Vec3(0, 0, 1);
  made.mNormalAxis1 = made.mNormalAxis2 = new J.Vec3(1, 0, 0);
  jolt.GetPhysicsSystem().AddConstraint(made.Create(parent, child));
}

// 1 kg each: m (a^2 + a^2) / 12 of the box, 2/5 m r^2 of the ball.
const ofBox = (0.125 * 0.125 + 0.125 * 0.125) / 12;
const ofBall = 0.4 * 0.05 * 0.05;
const cases = {
  sliding: {
    gravity: '0 0 -9.81',
    make: (jolt) => {
      body(jolt, new J.PlaneShape(new J.Plane(new J.Vec3(0, 0, 1), 0), undefined, 1e5), [0, 0, 0]);
      return {
        box: body(jolt, new J.BoxShape(new J.Vec3(0.0625, 0.0625, 0.0625), 0.03125), [0, 0, 0.0625], [1, 1, 0], ofBox),
        ball: body(jolt, new J.SphereShape(0.05), [1, 0, 0.5], [0.3, 0.1, 0], ofBall),
      };
    },
    scene: `<plane name="floor"/>
  <box name="box" size="0.125 0.125 0.125" mass="1 kg" xyz="0 0 0.0625" linear-velocity="1 1 0 m/s"/>
  <sphere name="ball" radius="5 cm" mass="1 kg" xyz="1 0 0.5" linear-velocity="0.3 0.1 0 m/s"/>`,
  },
  swinging: {
    gravity: '0 -9.81 0',
    make: (jolt) => {
      jolt.GetPhysicsSystem().SetGravity(new J.Vec3(0, -9.81, 0));
      const ball = (x) => body(jolt, new J.SphereShape(0.05), [x, 0, 0], [0, 0, 0], ofBall);
      const [upper, lower] = [ball(0.5), ball(0.75)];
      hinge(jolt, J.JoltInterface.prototype.sGetFixedToWorldBody(), upper, [0, 0, 0]);
      hinge(jolt, upper, lower, [0.5, 0, 0]);
      return { upper, lower };
    },
    scene: `<sphere name="upper" radius="5 cm" mass="1 kg" xyz="0.5 0 0"/>
  <sphere name="lower" radius="5 cm" mass="1 kg" xyz="0.75 0 0"/>
  <hinge name="shoulder" child="upper" xyz="0 0 0" axis="0 0 1"/>
  <hinge name="elbow" parent="upper" child="lower" xyz="0.5 0 0" axis="0 0 1"/>`,
  },
};

beside('jolt', cases, ({ make }) => {
  const jolt = makeWorld();
  const made = make(jolt);
  for (let step = 0; step < 1000; ++step) jolt.Step(0.001, 1);
  const positions = Object.entries(made).map(([body, it]) => {
    const p = it.GetPosition();
    return [body, [p.GetX(), p.GetY(), p.GetZ()]];
  });
  J.destroy(jolt);
  return Object.fromEntries(positions);
});
