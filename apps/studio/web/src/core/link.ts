// The way to whoever knows the run: a server at the other end of a WebSocket, or a bundle's memory.
import type { Failure, Frame, Picture, Tells } from "./protocol";

export class RequestError extends Error {
  constructor(readonly failure: Failure) {
    super(failure.help ? `${failure.message} (${failure.help})` : failure.message);
  }
}

export type Unsubscribe = () => void;

export interface Link {
  /** Rejects with RequestError when refused, and when the way is broken. */
  request<Answer = Record<string, unknown>>(what: string, fields?: Record<string, unknown>): Promise<Answer>;
  on<Name extends keyof Tells>(name: Name, listener: (tell: Tells[Name]) => void): Unsubscribe;
  /** The newest frame; called at most once per animation frame. */
  on_frame(listener: (frame: Frame) => void): Unsubscribe;
  on_picture(listener: (picture: Picture) => void): Unsubscribe;
  /** Whether there is an open way; changes are told. Broken ways are mended again and again. */
  on_open(listener: (open: boolean) => void): Unsubscribe;
  /** Address of a texture, from the path a shape names. */
  asset(path: string): string;
}
