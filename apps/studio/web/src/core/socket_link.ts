// The connection to a server: one WebSocket, opened again whenever it breaks.
import { decodeFrame, decodePicture } from "./decode";
import { RequestError, type Link, type Unsubscribe } from "./link";
import { LinkListeners, Listeners, nextPicture } from "./listeners";
import type { Frame } from "./frame";
import type { Failure, Topics } from "./protocol";

/** As much of a WebSocket as is needed; tests bring their own. */
export interface Socket {
  binaryType: string;
  readyState: number;
  onopen: (() => void) | null;
  onclose: (() => void) | null;
  onmessage: ((message: { data: unknown }) => void) | null;
  send(text: string): void;
  close(): void;
}

interface SocketLinkOptions {
  /** what lets the page in */
  key?: string;
  connect?: () => Socket;
  /** Calls back before the next picture is drawn. */
  nextPicture?: (then: () => void) => void;
}

interface Waiting {
  resolve(answer: unknown): void;
  reject(error: Error): void;
  timer: ReturnType<typeof setTimeout>;
}

const kOpen = 1;
/** [ms] Engines may take long to load a scene, compilers longer. */
const kPatience = 60_000;
const kPatienceOf: Record<string, number> = { build: 3_600_000, "debug-attach": 300_000 };
/** [ms] */
const kFirstDelay = 250;
const kLongestDelay = 5_000;

/** Requests that are repeated on a new connection, the last of each. */
const kStanding = ["subscribe", "cameras"];

export class SocketLink extends LinkListeners implements Link {
  private socket: Socket | null = null;
  private isOpen = false;
  private delay = kFirstDelay;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private nextId = 1;
  private readonly waiting = new Map<number, Waiting>();
  private readonly standing = new Map<string, Record<string, unknown>>();
  /** the newest that has not been handed out */
  private newest: Frame | null = null;
  private readonly opens = new Listeners<boolean>();
  private readonly connect: () => Socket;
  private readonly nextPicture: (then: () => void) => void;
  /** what addresses of textures begin with */
  private assets = "";

  constructor(options: SocketLinkOptions = {}) {
    super();
    const { key = "" } = options;
    this.connect = options.connect ?? (() => connectHere(key));
    this.nextPicture = options.nextPicture ?? nextPicture;
    this.open();
    if (typeof window !== "undefined") {
      window.addEventListener("online", () => this.tryNow());
      document.addEventListener("visibilitychange", () => {
        if (!document.hidden) this.tryNow();
      });
    }
  }

  request<Answer = Record<string, unknown>>(what: string, fields: Record<string, unknown> = {}): Promise<Answer> {
    if (kStanding.includes(what)) this.standing.set(what, fields);
    const socket = this.socket;
    if (!socket || !this.isOpen) {
      return Promise.reject(new RequestError({ message: "there is no connection to the studio", code: "closed" }));
    }
    return new Promise((resolve, reject) => {
      const id = this.nextId++;
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        reject(new RequestError({ message: `'${what}' was not answered in time`, code: "timeout" }));
      }, kPatienceOf[what] ?? kPatience);
      this.waiting.set(id, { resolve, reject, timer });
      socket.send(JSON.stringify({ ...fields, id, do: what }));
    });
  }
  onOpen(listener: (open: boolean) => void): Unsubscribe {
    if (this.isOpen) queueMicrotask(() => listener(true));
    return this.opens.add(listener);
  }
  asset(path: string): string {
    return this.assets && this.assets + path;
  }

  private open(): void {
    clearTimeout(this.retry);
    this.retry = undefined;
    const socket = this.connect();
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.isOpen = true;
      this.delay = kFirstDelay;
      this.opens.publish(true);
      for (const [what, fields] of this.standing) this.request(what, fields).catch(() => {});
    };
    socket.onmessage = ({ data }) => {
      try {
        if (typeof data === "string") this.takeText(data);
        else this.takeBytes(data as ArrayBuffer, socket);
      } catch (error) {
        console.error("a message that cannot be read:", error);
      }
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = null;
      this.newest = null;
      this.isOpen = false;
      for (const { reject, timer } of this.waiting.values()) {
        clearTimeout(timer);
        reject(new RequestError({ message: "the connection to the studio was lost", code: "closed" }));
      }
      this.waiting.clear();
      this.opens.publish(false);
      this.retry = setTimeout(() => this.open(), this.delay);
      this.delay = Math.min(2 * this.delay, kLongestDelay);
    };
  }

  /** Does not wait for the next try when there is reason to hope. */
  private tryNow(): void {
    if (this.retry !== undefined) this.open();
  }

  private takeText(text: string): void {
    const message = JSON.parse(text) as {
      id?: number;
      ok?: boolean;
      error?: Failure;
      topic?: keyof Topics;
      assets?: string;
    };
    if (typeof message.topic === "string") {
      this.publish(message.topic, message as never);
      return;
    }
    const waiting = this.waiting.get(message.id ?? -1);
    if (!waiting) return;
    this.waiting.delete(message.id!);
    clearTimeout(waiting.timer);
    if (typeof message.assets === "string") this.assets = message.assets;
    if (message.ok) waiting.resolve(message);
    else waiting.reject(new RequestError(message.error ?? { message: "refused without a reason" }));
  }

  private takeBytes(data: ArrayBuffer, socket: Socket): void {
    const say = (text: string) => {
      if (socket.readyState === kOpen) socket.send(text);
    };
    if (new Uint8Array(data, 0, 1)[0] === 2) {
      try {
        this.pictures.publish(decodePicture(data));
      } finally {
        say("p");
      }
      return;
    }
    let frame: Frame;
    try {
      frame = decodeFrame(data);
    } catch (error) {
      say("a");
      throw error;
    }
    const due = this.newest !== null;
    this.newest = frame;
    if (due) return;
    // The answer comes after drawing: a page that is slow gets fewer frames, not a queue of them.
    this.nextPicture(() => {
      if (this.socket !== socket) return;
      const now = this.newest;
      this.newest = null;
      if (!now) return;
      this.frames.publish(now);
      say("a");
    });
  }
}

function connectHere(key: string): Socket {
  const address = new URL("socket", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = "";
  address.hash = "";
  // A WebSocket has no headers of the page's but this one.
  return new WebSocket(address, ["cogrsim-studio", key]) as unknown as Socket;
}
