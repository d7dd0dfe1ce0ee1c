// The connection to the source of a run: a server at the other end of a WebSocket, or a bundle's memory.
import type { Frame, Picture } from "./frame";
import type { Answer, Failure, RequestName, Requests, Topics } from "./protocol";

export class RequestError extends Error {
  constructor(readonly failure: Failure) {
    super(failure.help ? `${failure.message} (${failure.help})` : failure.message);
  }
}

/** Of whatever was thrown. */
export const messageOf = (error: unknown): string => (error instanceof Error ? error.message : String(error));
/** Whether a request failed because there is no connection. */
export const isClosed = (error: unknown): boolean => error instanceof RequestError && error.failure.code === "closed";

/** Left out where no field is needed. */
export type FieldsOf<Name extends RequestName> =
  Record<string, never> extends Requests[Name]["fields"]
    ? [fields?: Requests[Name]["fields"]]
    : [fields: Requests[Name]["fields"]];

export type Unsubscribe = () => void;

export interface Link {
  /** Rejects with RequestError when refused, and when the connection is broken. */
  request<Name extends RequestName>(what: Name, ...fields: FieldsOf<Name>): Promise<Answer<Name>>;
  on<Name extends keyof Topics>(name: Name, listener: (message: Topics[Name]) => void): Unsubscribe;
  /** The newest frame; called at most once per animation frame. */
  onFrame(listener: (frame: Frame) => void): Unsubscribe;
  onPicture(listener: (picture: Picture) => void): Unsubscribe;
  /** Calls the listener when the connection opens or closes. A broken connection is tried again and again. */
  onOpen(listener: (open: boolean) => void): Unsubscribe;
  /** Address of a texture, from the path a shape names. */
  asset(path: string): string;
}
