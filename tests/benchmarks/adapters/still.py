"""An adapter whose engine does nothing: what remains is the exchange."""

from cogrsim_backend import Adapter, World, serve


class Still(World):

    def __init__(self, scene, state):
        self.state = state
        count = len(scene.bodies)
        self.touching = [[0, i, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 9.81] for i in range(1, min(9, count))]

    def step(self, step):
        pass

    def read(self, out):
        out.poses[:] = self.state.poses
        out.twists[:] = self.state.twists
        out.positions[:] = self.state.positions
        out.speeds[:] = self.state.speeds

    def write(self, state):
        self.state = state

    def contacts(self):
        return self.touching

    def reactions(self, out):
        pass

    def save(self):
        return b""

    def restore(self, content, state):
        pass


class Nothing(Adapter):
    version = "1.0"
    capabilities = {"*": "exact"}

    def provenance(self, options):
        stages = ("broad-phase", "narrow-phase", "contact-memory", "contact-law", "friction",
                  "restitution", "joints", "limits", "motors", "integrator")
        return {"engine": "still", "solver": "none", "formulation": "none", "integrator": "none",
                "stages": {stage: ("engine", "nothing") for stage in stages}}

    def build(self, scene, state, previous):
        return Still(scene, state)


serve(Nothing())
