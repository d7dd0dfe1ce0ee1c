// Codes of policy cards and their networks: CG15.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> policy_codes() {
  const Severity error = Severity::error;
  return {
      {"CG1501", error, "a policy card that cannot be read",
       "The file is not there, is no YAML map, has more than 1 MB, is nested deeper than 16, or "
       "uses "
       "aliases.",
       "Correct it at the place that the message names.", "bad:  rate: [50 Hz\ngood: rate: 50 Hz"},
      {"CG1502", error, "a word that policy cards do not have",
       "A key, a term of the observations or a kind of actions is not known, or a key stands "
       "twice.",
       "Correct it; the message states the nearest one, or all.",
       "bad:  - joint-position\ngood: - joint-positions"},
      {"CG1503", error, "a value of the wrong kind in a policy card",
       "The value is no number, list, word or map as its key needs it, is out of range, has the "
       "wrong "
       "unit or lacks one, or names a file that does not exist or lies outside of the card's "
       "folder.",
       "Write the value as the message says. Angles need their unit.",
       "bad:  default-pose: 0 0.9 -1.8\ngood: default-pose: 0 0.9 -1.8 rad"},
      {"CG1504", error, "what a policy card leaves open",
       "The card lacks something without which the policy would do other things than in its "
       "training: "
       "whose axes a velocity is in, what is added to the actions, whether the last action is "
       "clipped.",
       "Look it up where the policy was trained, and write it.",
       "bad:  - base-linear-velocity\ngood: - base-linear-velocity: {frame: base}"},
      {"CG1505", error, "a name that the robot of a policy does not have",
       "The card names a joint, body or frame that the scene does not have, or has several times.",
       "Correct the name; the message states the nearest one, or all.",
       "bad:  joints: [hip, knie]\ngood: joints: [hip, knee]"},
      {"CG1506", error, "sizes of a policy that do not add up",
       "The observations have more or fewer values than the network's input, the joints than its "
       "output, a list more or fewer entries than there are joints or values, or the network has "
       "an "
       "input or output that the card does not name.",
       "Compare the terms, which the message adds up, with those of the training.",
       "bad:  scale: [2, 2]\ngood: scale: [2, 2, 0.25]"},
      {"CG1507", error, "actions that the robot's motors cannot do",
       "A joint has no motor or several, or its motor's mode or gains are not those of the card.",
       "Correct the card, or give the robot motors as it was trained with.",
       "bad:  actions: {kind: position, …}, with motors in mode torque\n"
       "good: actions: {kind: position, kp: 100, kd: 2, …}"},
      {"CG1508", Severity::warning, "a policy's robot that may not be the one of its training",
       "The default pose lies beyond the limits of a joint, or the import leaves something out "
       "that may "
       "change how the robot moves.",
       "Check the order of the joints, and what `cogrsim import` reports.",
       "bad:  joints: [knee, hip] with the pose of hip and knee\ngood: joints: [hip, knee]"},
      {"CG1510", error, "a network that is no ONNX file",
       "The file is not there, or its bytes are not those of an ONNX model.",
       "Export the network as ONNX. TorchScript and checkpoints of trainers are other formats.",
       "bad:  network: motion.pt\ngood: network: motion.onnx"},
      {"CG1511", error, "a network beyond the limits",
       "The network has more bytes, nodes or values than a policy needs, or claims to have them.",
       "Export the policy alone, without critic and optimiser.",
       "bad:  a constant of 2 GB\ngood: some layers of some hundred values"},
      {"CG1512", error, "a network with what is not evaluated",
       "It uses an operator, attribute, type of number or size that is not evaluated: operators of "
       "others' domains, control flow, float16, weights in other files, sizes that are left open.",
       "Export it in float32, with fixed sizes, standard operators and all weights in one file.",
       "bad:  torch.onnx.export(…, dynamic_axes={'obs': [1]})\n"
       "good: torch.onnx.export(…, opset_version=17)"},
      {"CG1513", error, "a network that does not fit together",
       "A node reads what nothing before it makes, a value is made twice, or shapes do not fit.",
       "The file is damaged, or was changed by hand: export it again.",
       "bad:  a node that reads its own output"},
      {"CG1514", error, "what the files of another tool leave open about a policy",
       "A card needs it, and the files that `cogrsim policy import` was given do not have it: the "
       "file of "
       "the robot, the body that is observed, when it counts as fallen, or a number that only the "
       "program "
       "of that tool has.",
       "Answer as the message says, with --robot, --network, --base or --set KEY=VALUE; --set "
       "KEY=~ takes "
       "the default.",
       "bad:  cogrsim policy import g1.yaml -o g1.policy.yaml\n"
       "good: cogrsim policy import g1.yaml --network g1.onnx --set fallen=~ -o g1.policy.yaml"},
      {"CG1515", error, "a policy that a card cannot describe",
       "The files of another tool have an observation, action or actuator that cards do not have.",
       "Where an answer comes near, the message names its key. Else write a controller for it.",
       "bad:  full_path: isaaclab.envs.mdp.observations.image"},
  };
}

}  // namespace cogrsim::dsl
