"""Resident memory while many frames are made and used: frames.py [FRAMES]

Half of the frames are of one state, half are made by steps. Every one gives its views, and is dropped. Exit status 1: the
memory grew by more than 4 MiB from a tenth of the frames to all.
"""

import os
import resource
import sys

import numpy as np

import cogrsim as cg

SCENE = """<scene name="frames" version="1">
  <physics backend="cogrsim" step="1 ms"/>
  <plane name="ground"/>
  <sphere name="ball" radius="10 cm" mass="1 kg" xyz="0 0 1"/>
  <box name="crate" size="20 20 20 cm" mass="2 kg" xyz="1 0 0.1"/>
</scene>
"""


def resident():
    """Resident memory at present [KiB]; the maximum could hide growth below it."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def main():
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    if frames < 10:
        sys.exit(f"FRAMES: expected 10 or more, given {frames}")
    sim = cg.Simulation(cg.compile_string(SCENE))
    first = 0
    print(f"{'frames':>9} {'resident':>12} {'maximum':>12}")
    for made in range(1, frames + 1):
        frame = sim.step() if made % 2 else sim.frame
        position, contacts = frame.position, frame.contacts
        frame.orientation, frame.velocity, frame.sensors, frame["ball"].speed
        if made in (frames // 10, frames // 2, frames):
            assert np.shares_memory(position, frame.position) and not position.flags.writeable
            now = resident()
            first = first or now
            most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            print(f"{made:>9} {now:>8} KiB {most:>8} KiB", flush=True)
    print(f"{len(contacts)} contacts in the last one, {sim.step_count} steps; growth {now - first} KiB")
    return 1 if now - first > 4096 else 0


if __name__ == "__main__":
    sys.exit(main())
