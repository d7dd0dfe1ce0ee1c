// An engine that lacks something of the scene: what it lacks is left out of a run where the person says so, once.
import { RequestError, isClosed, messageOf, type FieldsOf } from "../core/link";
import type { Answer, LeftOut } from "../core/protocol";
import type { Studio } from "../core/studio";

/** Of a scene that an engine refuses for what it lacks. */
const kLacking = "CG0801";

export function leftOutText(all: readonly LeftOut[]): string {
  return all.map(({ feature, of, count }) => `${feature} (${count} × ${of})`).join(", ");
}

/** What a refusal is to be answered with; a text: why nothing helps; null: nothing is lacked, it has another reason. */
export function offerOf(lacking: Answer<"lacking">): string | { title: string; text: string } | null {
  const { name, needed } = lacking;
  if (needed.length > 0) return `${name} cannot run this scene: ${needed.join("; ")}`;
  if (lacking.left_out.length === 0) return null;
  return {
    title: `${name} lacks something of this scene`,
    text:
      `${name} has no ${leftOutText(lacking.left_out)}. It can run the scene without. ` +
      "Other engines then leave out what they lack, too, and only that, until everything is asked for again.",
  };
}

/** Makes a request that gives the run an engine; where that lacks something the person is asked. Refused otherwise: a
 *  notice, and null. */
export async function orWithout<Reply>(
  studio: Studio,
  lacking: FieldsOf<"lacking">[0],
  request: (without: string[] | null) => Promise<Reply>,
): Promise<Reply | null> {
  try {
    try {
      return await request(null);
    } catch (error) {
      if (!(error instanceof RequestError) || error.failure.code !== kLacking) throw error;
      const offer = offerOf(await studio.link.request("lacking", lacking));
      if (offer === null) throw error;
      if (typeof offer === "string") {
        studio.notify(offer, "error");
        return null;
      }
      return (await studio.dialog({ ...offer, fields: [], accept: "Leave it out" })) && (await request(["lacking"]));
    }
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
