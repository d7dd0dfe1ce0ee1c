/** Controllers of CogRSim in JavaScript: see docs/plugins/any-language.md, whose messages these are. */

export interface Motor {
  name: string;
  mode: 'velocity' | 'torque' | 'position' | 'servo' | 'dc';
  /** Limits of the joint axis [rad, m], -Infinity and Infinity where there are none. */
  lower: number;
  upper: number;
  /** [rad/s, m/s] and [N m, N] */
  max_speed: number;
  max_effort: number;
  /** [V], in the mode "dc" */
  max_voltage?: number;
}

/** Sent once, before the first update. */
export interface Hello {
  robot: string;
  backend: string;
  seed: number;
  /** Parameters of the scene that `--set` gave, as texts. */
  set: Record<string, string>;
  motors: Motor[];
  sensors: { name: string; type: string }[];
  outputs: string[];
}

export interface Picture {
  /** [pixel] */
  width: number;
  height: number;
  /** Bytes of a pixel. */
  channels: number;
  data: Uint8Array;
}

export interface Update {
  /** Simulated time, and since the last update [s]. */
  time: number;
  period: number;
  /** Of updates, from 1. */
  count: number;
  /** In the order of Hello: [rad, m], [rad/s, m/s], [N m, N]. */
  motors: { target: number; effort: number; position: number; velocity: number }[];
  /** In the order of Hello; without values until the first reading. */
  sensors: { valid: boolean; time?: number; sequence?: number; values?: number[]; picture?: Picture }[];
}

export interface Answer {
  /** In the order of the motors, null: unchanged; or by their names. SI units. */
  targets?: (number | null)[] | Record<string, number>;
  /** Of `output_1` to `output_8`. */
  outputs?: Record<string, number>;
  /** For the user. */
  report?: string;
  /** Ends the controller with this error. */
  fault?: string;
}

export type Step = (update: Update) => Answer | (number | null)[] | void | Promise<Answer | (number | null)[] | void>;

export interface Options {
  /** Of COGRSIM_CONTROLLER_TOKEN, which is the default. */
  token?: string;
  /** Updates have the pictures of cameras. */
  pictures?: boolean;
  /** Longest wait for the first simulation [s], 60. */
  wait?: number;
}

/**
 * Serves simulations at `unix:PATH` or `tcp:HOST:PORT`, also several at a time, until there are no more; the number of
 * those served. `begin` is called once for each, and gives what answers its updates.
 * Rejects with an Error when no simulation came, when one refuses this client, when a message is none, and with what
 * `begin` or a step threw, which its simulation gets as a fault.
 */
export function control(address: string, begin: (hello: Hello) => Step | Promise<Step>, options?: Options): Promise<number>;
