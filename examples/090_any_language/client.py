"""A controller of pendulum.scene.xml in plain Python: python3 client.py [unix:PATH | tcp:HOST:PORT]"""

import json
import os
import socket
import struct
import sys
import time


def connect(address, patience=30.0):
    """The connection to the simulation, which may not have started yet."""
    end = time.monotonic() + patience
    while True:
        try:
            if address.startswith("unix:"):
                link = socket.socket(socket.AF_UNIX)
                link.connect(address[5:])
            else:
                host, port = address.removeprefix("tcp:").rsplit(":", 1)
                link = socket.create_connection((host, int(port)))
                link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return link
        except (FileNotFoundError, ConnectionRefusedError):
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def send(link, message):
    data = json.dumps(message).encode()
    link.sendall(struct.pack(">I", len(data)) + data)


def receive(link):
    def exactly(count):
        data = b""
        while len(data) < count:
            part = link.recv(count - len(data))
            if not part:
                raise SystemExit("the simulation closed the connection")
            data += part
        return data

    return json.loads(exactly(struct.unpack(">I", exactly(4))[0]))


def main():
    link = connect(sys.argv[1] if len(sys.argv) > 1 else "unix:run.sock")
    send(link, {"type": "hello", "protocol": 1, "token": os.environ.get("COGRSIM_CONTROLLER_TOKEN", "")})
    robot = receive(link)
    print("controls", robot["robot"], "with", [motor["name"] for motor in robot["motors"]])
    goal = 0.5235987755982988  # 30 degrees
    while (message := receive(link))["type"] == "update":
        motor = message["motors"][0]
        error = goal - motor["position"]
        send(link, {"type": "set", "targets": [8.0 * error - 0.4 * motor["velocity"]],
                    "outputs": {"output_1": error}})


if __name__ == "__main__":
    main()
