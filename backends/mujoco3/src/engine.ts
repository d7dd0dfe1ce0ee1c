// The module of MuJoCo, and its models with the memory that they need.
import load, { type DoubleBuffer, type MainModule, type MjData, type MjModel } from '@mujoco/mujoco';

import { Refusal } from './cogrsim_backend.mjs';

export type { DoubleBuffer, MjData, MjModel };
// It writes to standard output, which is free.
export const mujoco: MainModule = await load();

export const kState = mujoco.mjtState.mjSTATE_INTEGRATION.value;
/** MuJoCo's own bound of a number in a state, mjMAXVAL. */
const kMost = 1e10;

/** Compiles MJCF; `memory` in bytes, 0: what MuJoCo takes. */
export function compile(xml: string, memory: number): MjModel {
  const text = memory > 0 ? xml.replace('<option ', `<size memory="${memory}"/>\n<option `) : xml;
  try {
    return mujoco.MjModel.from_xml_string(text);
  } catch (error) {
    const message = error instanceof Error ? error.message : String(error);
    throw new Refusal(`MuJoCo: ${message.replace(/\s+/g, ' ').trim()}`);
  }
}

export const idOf = (model: MjModel, kind: { value: number }, name: string): number =>
  mujoco.mj_name2id(model, kind.value, name);

/** What a step has warned of, counted since the data was reset: how often, and of which index the last. */
function warning(data: MjData, kind: { value: number }): { number: number; lastinfo: number } {
  // The list is the data's own: to delete its handle would empty it there.
  const it = data.warning.get(kind.value)!;
  const { number, lastinfo } = it;
  it.delete();
  return { number, lastinfo };
}

/** Contacts or rows of constraints did not have room. */
export function isFull(data: MjData): boolean {
  const { mjWARN_CONTACTFULL, mjWARN_CNSTRFULL } = mujoco.mjtWarning;
  return [mjWARN_CONTACTFULL, mjWARN_CNSTRFULL].some(kind => warning(data, kind).number > 0);
}

/** MuJoCo's body of a number that was beyond its bounds; -1: none was. */
export function badBody(model: MjModel, data: MjData): number {
  const { mjWARN_BADCTRL, mjWARN_BADQACC } = mujoco.mjtWarning;
  const effort = warning(data, mjWARN_BADCTRL);
  if (effort.number > 0) return model.jnt_bodyid[model.actuator_trnid[2 * effort.lastinfo]];
  const acceleration = warning(data, mjWARN_BADQACC);
  if (acceleration.number > 0) return model.dof_bodyid[acceleration.lastinfo];
  const bad = (x: number): boolean => !(Math.abs(x) < kMost);
  const { qpos, qvel } = data;
  if (!qpos.some(bad) && !qvel.some(bad)) return -1;
  for (let i = 0; i < model.njnt; ++i) {
    const last = i + 1 === model.njnt;
    const positions = qpos.slice(model.jnt_qposadr[i], last ? model.nq : model.jnt_qposadr[i + 1]);
    const speeds = qvel.slice(model.jnt_dofadr[i], last ? model.nv : model.jnt_dofadr[i + 1]);
    if (positions.some(bad) || speeds.some(bad)) return model.jnt_bodyid[i];
  }
  return -1;
}
