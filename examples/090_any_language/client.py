"""A controller of pendulum.scene.xml in plain Python: python3 client.py [unix:PATH | tcp:HOST:PORT]"""

import json
import os
import socket
import struct
import sys
import threading
import time

GOAL = 0.5235987755982988  # 30 degrees


def connect(address, patience):
    """A connection to the simulation, which may not have started yet; None: there is none."""
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
                return None
            time.sleep(0.05)


def send(link, message):
    data = json.dumps(message).encode()
    link.sendall(struct.pack(">I", len(data)) + data)


def receive(link):
    """The next message; None: the simulation has closed the connection."""
    def exactly(count):
        data = b""
        while len(data) < count:
            part = link.recv(count - len(data))
            if not part:
                raise ConnectionResetError
            data += part
        return data

    try:
        return json.loads(exactly(struct.unpack(">I", exactly(4))[0]))
    except ConnectionResetError:
        return None


def control(link):
    """Answers the updates of one simulation."""
    while (message := receive(link)) and message["type"] == "update":
        motor = message["motors"][0]
        error = GOAL - motor["position"]
        send(link, {"type": "set", "targets": [8.0 * error - 0.4 * motor["velocity"]],
                    "outputs": {"output_1": error}})
    link.close()


def main():
    address = sys.argv[1] if len(sys.argv) > 1 else "unix:run.sock"
    patience = 30.0
    # Several simulations, such as those of `cogrsim compare`: when one has taken the connection, the next
    # connection is opened, which waits for another simulation.
    while link := connect(address, patience):
        try:
            send(link, {"type": "hello", "protocol": 1, "token": os.environ.get("COGRSIM_CONTROLLER_TOKEN", "")})
            robot = receive(link)
        except BrokenPipeError:
            robot = None
        if robot is None:
            continue  # the last simulation has ended
        if robot["type"] == "refused":
            sys.exit(robot["reason"])
        print("controls", robot["robot"], "on", robot["backend"], "with", [m["name"] for m in robot["motors"]])
        threading.Thread(target=control, args=(link,)).start()
        patience = 1.0


if __name__ == "__main__":
    main()
