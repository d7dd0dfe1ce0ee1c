"""The backend @NAME@: what it can do, and its worlds. cogrsim_backend.py does the rest."""

import copy
import pickle

from cogrsim_backend import Adapter, Diverged, World, serve
from flight import Body, add, cross, norm, turn

# Beyond these a body has diverged: 1000 km, 100 km/s, 1e6 rad/s.
FARTHEST, FASTEST, FASTEST_SPIN = 1e6, 1e5, 1e6

MOTIONS = {"static": "still", "kinematic": "carried", "dynamic": "free"}


def moved_point(model):
    """The point that the engine moves, in body axes: the centre of mass; of a carried body its
    origin."""
    return model.com if model.kind == "dynamic" else [0.0, 0.0, 0.0]


def body_in(scene, state, b):
    """Body `b` of the scene with its motion in `state`, as the engine has it."""
    model = scene.bodies[b]
    pose, twist = list(state.poses[7 * b:7 * b + 7]), list(state.twists[6 * b:6 * b + 6])
    orientation, spin = pose[3:], twist[3:]
    arm = turn(orientation, moved_point(model))
    return Body(MOTIONS[model.kind], model.inertia, add(pose[:3], arm), orientation,
                add(twist[:3], cross(spin, arm)), spin)


class FlightWorld(World):

    def __init__(self, scene, state, previous):
        self.scene = scene
        self.bodies = []
        old = previous.bodies if previous else []
        for b, model in enumerate(scene.bodies):
            # After a change of the scene, bodies that stay what they were keep their last digits.
            stays = b < len(old) and (model.removed or old[b].motion == MOTIONS[model.kind])
            self.bodies.append(old[b] if stays else body_in(scene, state, b))

    def step(self, step):
        # On a copy: a failed step leaves the world as it was.
        bodies = [copy.copy(body) for body in self.bodies]
        substeps = self.scene.options["substeps"]
        for b, (model, body) in enumerate(zip(self.scene.bodies, bodies)):
            if model.removed:
                continue
            if model.kind == "kinematic":
                twist = list(step.twists[6 * b:6 * b + 6])
                body.velocity, body.spin = twist[:3], twist[3:]
            for _ in range(substeps):
                body.advance(self.scene.gravity, step.dt / substeps)
            # This form of the comparison also finds NaN.
            if not (norm(body.position) < FARTHEST and norm(body.velocity) < FASTEST
                    and norm(body.spin) < FASTEST_SPIN):
                raise Diverged(f"body '{model.name}' left all bounds (1000 km, 100 km/s)", b)
        self.bodies = bodies

    def read(self, out):
        for b, (model, body) in enumerate(zip(self.scene.bodies, self.bodies)):
            arm = turn(body.orientation, moved_point(model))
            for i, x in enumerate(add(body.position, arm, -1.0) + body.orientation):
                out.poses[7 * b + i] = x
            if body.motion == "still":
                continue
            velocity = add(body.velocity, cross(body.spin, arm), -1.0)
            for i, x in enumerate(velocity + body.spin):
                out.twists[6 * b + i] = x

    def write(self, state):
        self.bodies = [body_in(self.scene, state, b) for b in range(len(self.bodies))]

    def save(self):
        return pickle.dumps(self.bodies)

    def restore(self, content, state):
        self.bodies = pickle.loads(content)


class Flight(Adapter):
    # Ask the package of your engine, so that the version is that of the package in use.
    version = "0.1"
    # CogRSim refuses scenes by this table before build() is called, with the reason given here, so it
    # must be right. What is not named is unsupported.
    capabilities = {
        "shape.*": "exact",  # a shape alone is drawn only; collisions are features of pairs
        "pair.*": ("unsupported", "collisions are not computed"),
        "contact.*": ("unsupported", "collisions are not computed"),
        "joint.*": ("unsupported", "bodies fly freely, there are no joints"),
        "loop.*": ("unsupported", "bodies fly freely, there are no joints"),
        "motor.*": ("unsupported", "there are no joints to drive"),
        "runtime.*": "exact",
        "runtime.attach": ("unsupported", "there are no joints"),
        "runtime.joint_axes": ("unsupported", "there are no joints"),
        "body.static": "exact",
        "body.kinematic": "exact",
        "body.force": ("unsupported", "forces from outside are not applied"),
        "report.contact_force": ("unsupported", "collisions are not computed"),
        "report.joint_*": ("unsupported", "there are no joints"),
    }
    options = [{
        "name": "substeps", "type": "integer", "default": 1, "minimum": 1, "maximum": 1000,
        "description": "number of equal parts of each step",
    }]

    def provenance(self, options):
        # Every result states which code computed it: the engine, or code of this folder ("cogrsim").
        stages = dict.fromkeys(
            ("broad-phase", "narrow-phase", "contact-memory", "contact-law", "friction",
             "restitution", "joints", "limits", "motors"), ("none", "bodies fly freely"))
        stages["integrator"] = ("engine", "flight.Body.advance")
        return {"engine": "flight", "solver": "none", "formulation": "none",
                "integrator": "exact free flight", "stages": stages}

    def build(self, scene, state, previous):
        return FlightWorld(scene, state, previous)


serve(Flight())
