"""The network that trots: what it computes, its start, and its file.

With x what it reads, (sin, cos) the phase of the stride, and z = (command, spin, gravity) a part of x,

    a = W (x, sin z, cos z, sin cos, cos cos, 1)

so feedback may differ between the leg that swings and the one that stands. W is symmetric: the mirrored robot half a
stride later does what the mirror shows, which halves what must be learned.
"""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LEGS = ["front_left", "front_right", "rear_left", "rear_right"]
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("roll", "pitch", "knee")]
LEAN = np.arctan2(np.sqrt(4 * 0.2**2 - 0.3**2), 0.3)  # two links of 20 cm bear the hip 30 cm above the foot
POSE: Floats = np.round(np.tile([0.0, LEAN, -2 * LEAN], 4), 4)
SCALE = 0.25               # of an action [rad]
PERIOD, FREQUENCY = 0.02, 2.0  # of decisions [s], and of strides [Hz]

# What it reads, in the order of the card: spin, gravity, joints' angles and speeds, command, phase.
SIZES = [3, 3, 12, 12, 3, 2]
SPIN, GRAVITY, ANGLES, SPEEDS, COMMAND, PHASE = (
    list(range(sum(SIZES[:i]), sum(SIZES[:i + 1]))) for i in range(len(SIZES)))
READ = sum(SIZES)
MEASURED = SPIN + GRAVITY + ANGLES + SPEEDS
SIN, COS = PHASE
PRODUCTS = [(p, q) for p in PHASE for q in COMMAND + SPIN + GRAVITY] + [(COS, SIN), (COS, COS)]
FEATURES = READ + len(PRODUCTS) + 1


def _mirror() -> tuple[Floats, Floats]:
    """Signed permutations: features and actions of the robot in a mirror, left and right exchanged, half a stride
    later."""
    legs = np.kron([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]], np.diag([-1.0, 1.0, 1.0]))
    read = np.zeros((READ, READ))
    for part, signs in ((SPIN, [-1, 1, -1]), (GRAVITY, [1, -1, 1]), (COMMAND, [1, -1, -1]), (PHASE, [-1, -1])):
        read[part, part] = signs
    for part in (ANGLES, SPEEDS):
        read[np.ix_(part, part)] = legs
    features = np.zeros((FEATURES, FEATURES))
    features[:READ, :READ] = read
    for i, (p, q) in enumerate(PRODUCTS, start=READ):
        features[i, i] = read[p, p] * read[q, q]
    features[-1, -1] = 1.0
    return features, legs


MIRROR_READ, MIRROR_ACT = _mirror()


def weights(free: Floats) -> Floats:
    """The symmetric W of parameters of the same shape, (…, 12, FEATURES)."""
    out: Floats = 0.5 * (free + MIRROR_ACT @ free @ MIRROR_READ)
    return out


def features(read: Floats) -> Floats:
    left, right = zip(*PRODUCTS)
    products = read[:, list(left)] * read[:, list(right)]
    return np.concatenate([read, products, np.ones((len(read), 1))], axis=1)


def act(weight: Floats, read: Floats) -> Floats:
    """Actions (n, 12) of n networks (n, 12, FEATURES) that read (n, READ)."""
    out: Floats = np.einsum("naf,nf->na", weight, features(read))
    return out


def start() -> Floats:
    """Trots blindly: in turn two legs across bend their knees by 0.2 rad and their hips by half of it, and swing by
    0.4 rad for each m/s ahead."""
    out = np.zeros((len(JOINTS), FEATURES))
    swing = READ + PRODUCTS.index((COS, COMMAND[0]))
    for leg in range(4):
        side = 1.0 if leg in (0, 3) else -1.0
        pitch, knee = 3 * leg + 1, 3 * leg + 2
        out[pitch, SIN] = side * 0.1 / SCALE
        out[knee, SIN] = -side * 0.2 / SCALE
        out[pitch, swing] = side * 0.4 / SCALE
    return out


def write(weight: Floats, path: str) -> None:
    """As ONNX, in float32."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    left, right = zip(*PRODUCTS)
    tensors = {"left": np.array(left), "right": np.array(right),
               "weight": weight[:, :-1].astype(np.float32), "offset": weight[:, -1].astype(np.float32)}
    graph = helper.make_graph(
        [helper.make_node("Gather", ["observation", "left"], ["one"], axis=1),
         helper.make_node("Gather", ["observation", "right"], ["other"], axis=1),
         helper.make_node("Mul", ["one", "other"], ["products"]),
         helper.make_node("Concat", ["observation", "products"], ["features"], axis=1),
         helper.make_node("Gemm", ["features", "weight", "offset"], ["action"], transB=1)],
        "trot",
        [helper.make_tensor_value_info("observation", TensorProto.FLOAT, [1, READ])],
        [helper.make_tensor_value_info("action", TensorProto.FLOAT, [1, len(JOINTS)])],
        [numpy_helper.from_array(value, name) for name, value in tensors.items()])
    model = helper.make_model(graph, producer_name="cogrsim", opset_imports=[helper.make_opsetid("", 13)])
    model.ir_version = 8
    onnx.checker.check_model(model)
    onnx.save(model, path)
