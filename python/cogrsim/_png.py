"""PNG of an image, with the standard library."""

import struct
import zlib


def encoded(image):
    """image: (height, width, 3) uint8."""
    height, width = image.shape[:2]
    rows = b"".join(b"\0" + image[i].tobytes() for i in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b""))
