// An engine that lacks something of the scene: what it lacks is left out of a run where the person says so, once.
import { RequestError, isClosed, messageOf } from "../core/link";
import type { Answer, LeftOut } from "../core/protocol";
import type { Studio } from "../core/studio";

/** Of a scene that an engine refuses for what it lacks. */
const kLacking = "CG0801";

export function leftOutText(all: readonly LeftOut[]): string {
  return all.map(({ feature, of, count }) => `${feature} (${count} × ${of})`).join(", ");
}

/** What a refusal of `backend` is to be answered with; a text: nothing helps. */
export function offerOf(lacking: Answer<"lacking">): string | { title: string; text: string } {
  const { name, needed } = lacking;
  if (needed.length > 0) return `${name} cannot run this scene: ${needed.join("; ")}`;
  if (lacking.left_out.length === 0) return `${name} lacks nothing of this scene`;
  return {
    title: `${name} lacks something of this scene`,
    text:
      `${name} has no ${leftOutText(lacking.left_out)}. It can run the scene without. ` +
      "Other engines then leave out what they lack, too, and only that, until everything is asked for again.",
  };
}

/** Whether the run is to leave out what `backend` lacks ("": the scene's engine); null: no. */
async function ask(studio: Studio, backend: string): Promise<string[] | null> {
  const offer = offerOf(await studio.link.request("lacking", { name: backend }));
  if (typeof offer === "string") {
    studio.notify(offer, "error");
    return null;
  }
  return (await studio.dialog({ ...offer, fields: [], accept: "Leave it out" })) && ["lacking"];
}

/** Makes a request that gives the run an engine; where that lacks something the person is asked. Refused otherwise: a
 *  notice, and null. */
export async function orWithout<Reply>(
  studio: Studio,
  backend: string,
  request: (without: string[] | null) => Promise<Reply>,
): Promise<Reply | null> {
  try {
    try {
      return await request(null);
    } catch (error) {
      if (!(error instanceof RequestError) || error.failure.code !== kLacking) throw error;
    }
    const without = await ask(studio, backend);
    return without && (await request(without));
  } catch (error) {
    if (!isClosed(error)) studio.notify(messageOf(error), "error");
    return null;
  }
}

/** Whether the newest text is refused by the present engine for what that lacks. */
export function isRefused(studio: Studio): boolean {
  return studio.state.problems.value.some((problem) => problem.severity === "error" && problem.code === kLacking);
}

/** What a run leaves out, by engine: that of the run, and of the second one of a comparison. */
export function leftOutByEngine(studio: Studio): { engine: string; all: LeftOut[] }[] {
  const status = studio.state.status.value;
  if (!status) return [];
  const second = status.compare;
  return [
    { engine: status.backend, all: status.provenance?.left_out ?? [] },
    { engine: second?.labels[1] ?? "", all: second?.left_out ?? [] },
  ].filter(({ all }) => all.length > 0);
}
