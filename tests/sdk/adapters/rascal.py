"""An adapter that moves bodies along their velocities, and does what the file `fault` beside it says:
"CALL WHAT", the call in which it misbehaves and how."""

import errno
import os
import random
import signal
import socket
import sys
import threading
import time

import cogrsim_backend
from cogrsim_backend import Adapter, Refusal, World, serve

with open("fault", encoding="utf-8") as file:
    CALL, WHAT = (file.read().split() + ["none", "none"])[:2]


def send(content):
    os.write(3, content)


def tried(what):
    try:
        what()
    except OSError as error:
        return errno.errorcode[error.errno]
    return "done"


def misbehave(call):
    if call != CALL:
        return
    if WHAT == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    elif WHAT == "exit":
        print("goodbye")
        sys.stdout.flush()
        os._exit(7)
    elif WHAT == "hang":
        time.sleep(1000)
    elif WHAT == "garbage":
        send(b"Loading the engine ... done. Have fun!\n")
    elif WHAT == "cut":
        send(cogrsim_backend._HEAD.pack(cogrsim_backend._MARK, 5, 1000) + bytes(10))
        os._exit(0)
    elif WHAT == "endless":
        send(cogrsim_backend._HEAD.pack(cogrsim_backend._MARK, 5, 1 << 62))
    elif WHAT == "short":
        send(cogrsim_backend._HEAD.pack(cogrsim_backend._MARK, 5, 24) + bytes(24))
    elif WHAT == "throw":
        raise ValueError("no licence today")
    elif WHAT == "refuse":
        raise Refusal("the engine has no bodies left")
    elif WHAT == "chatter":
        for _ in range(20000):
            print("step " + 60 * "x")
        sys.stdout.flush()


class Moved(World):

    def __init__(self, scene, state):
        misbehave("build")
        self.scene, self.state = scene, state

    def step(self, step):
        misbehave("step")
        for body in range(len(self.scene.bodies)):
            for i in range(3):
                self.state.poses[7 * body + i] += step.dt * self.state.twists[6 * body + i]

    def read(self, out):
        out.poses[:] = self.state.poses
        out.twists[:] = self.state.twists
        if CALL == "read":
            out.poses[3 if WHAT == "length" else 2] = 0.5 if WHAT == "length" else float("nan")

    def contacts(self):
        if CALL != "contacts":
            return []
        body = {"cut": [0.0] * 13, "nobody": [99.0] + [0.0] * 13, "nan": [0.0] * 13 + [float("nan")]}
        return [body[WHAT]]

    def write(self, state):
        self.state = state

    def save(self):
        misbehave("save")
        return self.state.poses.tobytes() + self.state.twists.tobytes()

    def restore(self, content, state):
        values = memoryview(content).cast("d")
        self.state.poses[:] = values[:len(self.state.poses)]
        self.state.twists[:] = values[len(self.state.poses):]


class Rascal(Adapter):
    version = "1.0"
    capabilities = {"shape.*": "exact", "runtime.*": "exact", "report.contact_force": "exact"}

    def provenance(self, options):
        stages = ("broad-phase", "narrow-phase", "contact-memory", "contact-law", "friction",
                  "restitution", "joints", "limits", "motors", "integrator")
        return {"engine": "rascal", "solver": "none", "formulation": "none", "integrator": "Euler",
                "stages": {stage: ("engine", "Moved.step") for stage in stages}}

    def build(self, scene, state, previous):
        return Moved(scene, state)


if CALL == "hello":
    misbehave("hello")
elif CALL == "version":
    cogrsim_backend.PROTOCOL = 2
elif CALL == "capability":
    Rascal.capabilities = {"joint.elbow": "exact"}
elif CALL == "note":
    Rascal.capabilities = {"joint.hinge": ["approximate", ""]}
elif CALL == "reaction":
    Rascal.capabilities = {"report.joint_reaction": "exact"}
elif CALL == "reach":
    Rascal.version = " ".join([
        tried(lambda: open("own", "w", encoding="utf-8").close()), tried(lambda: os.listdir("..")),
        tried(lambda: open("../outside", "w", encoding="utf-8").close()), tried(socket.socket),
        tried(lambda: os.kill(os.getppid(), 0)), tried(lambda: os.listdir("/usr"))])
elif CALL == "soon":
    # At a random moment of some exchange or between two.
    after = random.Random(int(WHAT)).uniform(0.0, 0.02)
    threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGKILL)).start()
elif CALL == "after":
    threading.Timer(float(WHAT), lambda: os.kill(os.getpid(), signal.SIGKILL)).start()
serve(Rascal())
