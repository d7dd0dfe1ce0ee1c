"""Controllers in other languages: the same run as with a library, and faults with names.

    socket_test.py PROGRAM EXAMPLE_FOLDER
"""

import json
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROGRAM, EXAMPLE = sys.argv[1], pathlib.Path(sys.argv[2])
LIBRARY_JS = EXAMPLE.parent.parent / "sdk/controller/cogrsim_controller.mjs"
SCENE = (EXAMPLE / "pendulum.scene.xml").read_text(encoding="utf-8")
CONNECT = '<controller connect="unix:run.sock" rate="500 Hz"/>'
# The same law in a library: kp e + I - kd u, with I = 0.
LIBRARY = """<controller plugin="joint_pid" rate="500 Hz">
      <set motors="torque" target="0.5235987755982988 rad" kp="8" ki="0" kd="0.4"/></controller>"""


def message(value):
    data = value if isinstance(value, bytes) else json.dumps(value).encode()
    return struct.pack(">I", len(data)) + data


class Socket(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cgs_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def scene(self, controller):
        assert CONNECT in SCENE
        path = self.folder / "run.scene.xml"
        path.write_text(SCENE.replace(CONNECT, controller), encoding="utf-8")
        return path

    def run_scene(self, controller, client=None, environment=None, arguments=()):
        """The result of a run with a client (a command or a function), and what it printed."""
        path = self.scene(controller)
        (self.folder / "out.json").unlink(missing_ok=True)
        run = subprocess.Popen([PROGRAM, "run", str(path), "--json", str(self.folder / "out.json"), "--overwrite",
                                *arguments],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=self.folder,
                               env={**os.environ, **(environment or {})})
        other = None
        if callable(client):
            other = threading.Thread(target=client)
            other.start()
        elif client:
            other = subprocess.Popen(client, cwd=self.folder, stdout=subprocess.DEVNULL)
        out, err = run.communicate(timeout=300)
        if callable(client):
            other.join(60)
        elif other:
            self.assertEqual(other.wait(60), 0)
        result = self.folder / "out.json"
        return (json.loads(result.read_text()) if result.exists() else None), out + err

    def check_client(self, command, controller=CONNECT):
        library, _ = self.run_scene(LIBRARY)
        remote, printed = self.run_scene(controller, command)
        self.assertIsNotNone(remote, printed)
        self.assertEqual(remote["state_hash"], library["state_hash"], printed)
        self.assertFalse((self.folder / "run.sock").exists())

    def test_python(self):
        self.check_client([sys.executable, str(EXAMPLE / "client.py")])

    def test_a_folder_longer_than_an_address(self):
        self.folder /= "d" * 120
        self.folder.mkdir()
        self.check_client([sys.executable, str(EXAMPLE / "client.py")])

    def test_python_over_tcp(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            address = f"tcp:127.0.0.1:{probe.getsockname()[1]}"
        self.check_client([sys.executable, str(EXAMPLE / "client.py"), address],
                          CONNECT.replace("unix:run.sock", address))

    @unittest.skipUnless(shutil.which("node"), "no node")
    def test_javascript(self):
        self.check_client(["node", str(EXAMPLE / "client.mjs")])

    def library_client(self, step):
        """A client of the library for JavaScript, whose step has this body; ends with 3 and what was thrown."""
        path = self.folder / "own.mjs"
        path.write_text(f"""import {{ control }} from "{LIBRARY_JS.as_uri()}";
await control("unix:run.sock", ({{ robot, backend, motors }}) => {{
  console.log("controls", robot, "on", backend);
  return (update) => {{ {step} }};
}})
  .catch((error) => {{ console.error(error.message); process.exit(3); }});
""", encoding="utf-8")
        return ["node", str(path)]

    JS_LAW = ("const { position, velocity } = update.motors[0]; const e = 0.5235987755982988 - position;"
              "return { targets: { [motors[0].name]: 8.0 * e - 0.4 * velocity }, outputs: { output_1: e } };")

    @unittest.skipUnless(shutil.which("node"), "no node")
    def test_javascript_library(self):
        self.check_client(self.library_client(self.JS_LAW))
        self.check_comparison(self.library_client(self.JS_LAW))

    @unittest.skipUnless(shutil.which("node"), "no node")
    def test_javascript_library_that_throws(self):
        self.scene(CONNECT)
        client = subprocess.Popen(self.library_client('throw new Error("no idea");'), cwd=self.folder,
                                  stderr=subprocess.PIPE, text=True)
        _, printed = self.run_scene(CONNECT)
        self.assertIn("no idea", printed)
        self.assertIn("no idea", client.communicate(timeout=60)[1])
        self.assertEqual(client.returncode, 3)

    @unittest.skipUnless(shutil.which("cc"), "no C compiler")
    def test_c(self):
        program = self.folder / "client"
        subprocess.run(["cc", "-Wall", "-Wextra", "-Werror", "-D_DEFAULT_SOURCE", "-std=c11", "-ffp-contract=off",
                        str(EXAMPLE / "client.c"), "-o", str(program)], check=True)
        self.check_client([str(program)])

    @unittest.skipUnless(shutil.which("octave-cli"), "no Octave")
    def test_octave(self):
        if subprocess.run(["octave-cli", "--eval", "pkg load sockets"], capture_output=True).returncode != 0:
            self.skipTest("no octave-sockets")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = str(probe.getsockname()[1])
        self.check_client(["octave-cli", str(EXAMPLE / "client.m"), "127.0.0.1", port],
                          CONNECT.replace("unix:run.sock", "tcp:127.0.0.1:" + port))

    def check_comparison(self, client):
        path = self.scene(CONNECT)
        other = subprocess.Popen(client, cwd=self.folder, stdout=subprocess.PIPE, text=True)
        run = subprocess.run([PROGRAM, "compare", str(path), "--backends", "cogrsim,bullet,ode", "--json", "-"],
                             capture_output=True, text=True, cwd=self.folder, timeout=300)
        printed, _ = other.communicate(timeout=60)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(other.returncode, 0)
        for backend in ("cogrsim", "bullet", "ode"):
            self.assertIn("controls robot on " + backend, printed)
        for entry in json.loads(run.stdout)["joints"]:
            # All hold the goal: the steady error of the law, g m l / 8, is the same everywhere.
            self.assertLess(entry["angle"]["end"], 1e-3, entry["other"])

    def test_one_client_for_all_engines_of_a_comparison(self):
        self.check_comparison([sys.executable, "-u", str(EXAMPLE / "client.py")])

    @unittest.skipUnless(shutil.which("node"), "no node")
    def test_one_client_in_javascript_for_a_comparison(self):
        self.check_comparison(["node", str(EXAMPLE / "client.mjs")])

    def test_one_client_for_engines_one_after_the_other(self):
        path = self.scene(CONNECT)
        text = path.read_text(encoding="utf-8").replace(
            "</scene>", '<test name="holds"><expect that="robot.pivot.position gt 0.3 rad"/></test></scene>')
        path.write_text(text, encoding="utf-8")
        other = subprocess.Popen([sys.executable, str(EXAMPLE / "client.py")], cwd=self.folder,
                                 stdout=subprocess.DEVNULL)
        run = subprocess.run([PROGRAM, "test", str(path), "--backends", "cogrsim,ode", "--jobs", "1"],
                             capture_output=True, text=True, cwd=self.folder, timeout=300)
        self.assertEqual(other.wait(60), 0)
        self.assertIn("2 passed", run.stdout, run.stderr)

    def test_hello_describes_run_and_limits(self):
        path = self.scene(CONNECT)
        text = path.read_text(encoding="utf-8")
        text = text.replace('<assembly name="robot"', '<param name="lift" type="length" default="1 m"/>\n'
                                                      '<assembly name="robot"', 1)
        text = text.replace('axis="0 -1 0"/>', 'axis="0 -1 0" lower="-1 rad" upper="2 rad" max-speed="7 rad/s"/>'
                                               '<encoder name="angle" joint="pivot"/>')
        hello = {}

        def act(link):
            link.sendall(message({"type": "hello", "protocol": 1}))
            size = struct.unpack(">I", link.recv(4))[0]
            hello.update(json.loads(link.recv(size)))
        self.scene = lambda _: path
        path.write_text(text, encoding="utf-8")
        self.run_scene("", self.client(act), arguments=["--seed", "9007199254740993", "--set", "lift=40 cm",
                                                               "--backend", "ode"])
        self.assertEqual({key: hello[key] for key in ("protocol", "robot", "backend", "seed", "set")},
                         {"protocol": 1, "robot": "robot", "backend": "ode", "seed": 9007199254740993,
                          "set": {"lift": "40 cm"}})
        self.assertEqual(hello["motors"], [{"name": "torque", "mode": "torque", "lower": -1, "upper": 2,
                                            "max_speed": 7, "max_effort": 2}])
        self.assertEqual(hello["sensors"], [{"name": "angle", "type": "encoder"}])

    # ---- clients that misbehave

    def client(self, act):
        """A function that connects and does `act(link)`."""
        def go():
            end = time.monotonic() + 30
            while True:
                link = socket.socket(socket.AF_UNIX)
                try:
                    link.connect(str(self.folder / "run.sock"))
                    break
                except OSError:
                    link.close()
                    if time.monotonic() > end:
                        return
                    time.sleep(0.02)
            with link:
                try:
                    act(link)
                except OSError:
                    pass
        return go

    def fault(self, act, controller=CONNECT, environment=None):
        _, printed = self.run_scene(controller, self.client(act) if act else None, environment)
        return printed

    def test_a_client_that_dies(self):
        def act(link):
            link.sendall(message({"type": "hello", "protocol": 1}))
            link.recv(1000)
        printed = self.fault(act)
        self.assertIn("the client closed the connection", printed)
        self.assertIn("'robot'", printed)

    def test_a_client_that_hangs(self):
        done = threading.Event()

        def act(link):
            link.sendall(message({"type": "hello", "protocol": 1}))
            done.wait(20)
        controller = CONNECT.replace("/>", "><set patience='0.3'/></controller>")
        timer = threading.Timer(3.0, done.set)
        timer.start()
        self.assertIn("the client did not answer in time", self.fault(act, controller))
        timer.cancel()

    def test_no_client(self):
        controller = CONNECT.replace("/>", "><set wait='0.2'/></controller>")
        self.assertIn("no client connected in time", self.fault(None, controller))

    def test_wrong_messages(self):
        hello = message({"type": "hello", "protocol": 1})
        for bad, text in ((b"\xff\xff\xff\xff", "announced a message"),
                          (message(b"no json"), "no JSON object"),
                          (message(b"[" * 100000), "nested deeper than 64"),
                          (message(b"[" + b"[]," * 300000 + b"0]"), "more than 200000 values"),
                          (message({"type": "update"}), "'set' was expected"),
                          (message({"type": "set", "targets": [1, 2]}), "expected 1"),
                          (message({"type": "set", "targets": {"troque": 1}}), "no motor 'troque'"),
                          (message({"type": "set", "targets": ["a"]}), "expected a number"),
                          (message({"type": "set", "outputs": {"output_9": 1}}), "output_9"),
                          (message({"type": "set", "target": [1]}), "unknown field 'target'"),
                          (message({"type": "set", "targets": [1e999]}), "no JSON object"),
                          (message({"fault": "my own words"}), "my own words")):
            def act(link, bad=bad):
                link.sendall(hello + bad)
                time.sleep(0.3)
                link.recv(10)
            self.assertIn(text, self.fault(act), text)

    def test_the_token(self):
        secret = {"COGRSIM_CONTROLLER_TOKEN": "0123456789abcdef"}

        def act(link):
            link.sendall(message({"type": "hello", "protocol": 1, "token": "0123456789abcdeg"}))
            self.answer = link.recv(1000)
        self.assertIn("the client's token is wrong", self.fault(act, environment=secret))
        self.assertIn(b"refused", self.answer)
        self.assertIn("16 characters", self.fault(None, environment={"COGRSIM_CONTROLLER_TOKEN": "short"}))

    def test_addresses(self):
        for address, text in (("unix:/tmp/x.sock", "inside the scene's folder"),
                              ("unix:../x.sock", "inside the scene's folder"),
                              ("unix:a/../../x.sock", "inside the scene's folder"),
                              ("unix:", "inside the scene's folder"),
                              ("unix:run.scene.xml", "not a socket"),
                              ("unix:missing/run.sock", "no folder inside"),
                              ("unix:" + "x" * 200, "too long"),
                              ("tcp:127.0.0.1", "no port"),
                              ("tcp:127.0.0.1:70000", "no port"),
                              ("tcp:example.org:5000", "in numbers"),
                              ("tcp:0.0.0.0:5000", "COGRSIM_CONTROLLER_TOKEN"),
                              ("udp:1", "is not an address")):
            self.assertIn(text, self.fault(None, CONNECT.replace("unix:run.sock", address)), address)
        os.symlink("/tmp", self.folder / "out")
        self.assertIn("no folder inside", self.fault(None, CONNECT.replace("unix:run.sock", "unix:out/x.sock")))

    def test_a_socket_left_behind_is_replaced(self):
        left = socket.socket(socket.AF_UNIX)
        left.bind(str(self.folder / "run.sock"))
        left.close()
        self.check_client([sys.executable, str(EXAMPLE / "client.py")])

    def test_plugin_and_connect(self):
        self.assertIn("CG0904", self.fault(None, '<controller plugin="joint_pid" connect="unix:a"/>'))
        self.assertIn("CG0204", self.fault(None, "<controller/>"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
